"""HAMR-full's leg reduced to its two actuator tips: the coordinates in which the published figures are given."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hamr_dynamics.leg import inertia

from . import transmission
from .leg import full_leg
from .parameters import leg_parameters

ZERO = (0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Reduced:
    """A leg at rest with its tips held at a deflection, front-left frame.

    Attributes:
        q: (2,) hip angles, rad. foot: (3,) mm. mass: (2, 2) g. stiffness: (2, 2) N/mm. damping: (2, 2) N ms/mm.
        ratios: angle -> (2,) derivative by the tips, rad/mm; hip angles "swing" and "lift", flexures by name.
        foot_ratio: (3, 2) foot per tip, mm/mm. angles: flexure -> rad.
    """

    q: np.ndarray
    foot: np.ndarray
    mass: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    ratios: dict[str, np.ndarray]
    foot_ratio: np.ndarray
    angles: dict[str, float]

    def modes(self) -> list[tuple[float, float]]:
        """(frequency Hz, quality factor) of the two modes, slower first, from the damped eigenvalues."""
        inverse = np.linalg.inv(self.mass)
        system = np.block([[np.zeros((2, 2)), np.eye(2)], [-inverse @ self.stiffness, -inverse @ self.damping]])
        roots = sorted((r for r in np.linalg.eigvals(system) if r.imag > 0), key=abs)
        return [(1e3 * abs(r) / (2 * np.pi), abs(r) / (-2 * r.real)) for r in roots]


def reduce(tips=ZERO, *, leg: str = "fl", rail: bool = True) -> Reduced:
    """The leg at tip deflections (2,) mm (swing, lift)."""
    p = leg_parameters(leg, rail=rail)
    q = hip_angles(tips, p)
    t = transmission.solve(tuple(q), p)
    state = full_leg(tuple(q), ZERO, ZERO, p)
    terms = inertia(state.bodies, ZERO, (0.0,) * 3, (0.0,) * 3)
    back = np.linalg.inv(np.array([tip.d for tip in t.tips], float))  # hip angles per tip
    angles = transmission.flexure_angles(t) | {"swing": t.swing.angle, "lift": t.lift.angle}
    foot = transmission.foot(t, p)
    return Reduced(
        q=q,
        foot=np.array([c.value for c in foot], float),
        mass=back.T @ _matrix(terms.leg) @ back,
        stiffness=back.T @ _matrix(state.stiffness) @ back,
        damping=back.T @ _matrix(state.damping) @ back,
        ratios={name: np.array(a.d, float) @ back for name, a in angles.items()},
        foot_ratio=np.array([c.d for c in foot], float) @ back,
        angles={name: float(a.value) for name, a in angles.items()},
    )


def hip_angles(tips, p: dict) -> np.ndarray:
    """Hip angles (2,) rad at tip deflections (2,) mm, by Newton's method on the closed form."""
    q = np.zeros(2)
    for _ in range(50):
        solved = transmission.solve(tuple(q), p).tips
        error = np.array([tip.value for tip in solved], float) - tips
        if np.abs(error).max() < 1e-13:
            break
        q = q - np.linalg.solve(np.array([tip.d for tip in solved], float), error)
    return q


def _matrix(m) -> np.ndarray:
    return np.array([[m[0], m[1]], [m[1], m[2]]], float)
