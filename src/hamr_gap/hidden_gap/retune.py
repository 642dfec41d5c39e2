"""How well the leg without an effect explains a run once its parameters are tuned again, in floors of the sensor noise.

Tuned: drive gain, stiffness, damping, inertia and preload of each joint, gain and bias of each channel, one common time shift.
Sensitivities come from the linear leg, with the run's own angles as input; Gauss-Newton steps with the real one make up for that.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.linalg import expm

from hamr_description.numbers import value
from hamr_description.simple_constants import simple_constants
from hamr_description.units import length_to_si, time_from_si

from .case import JOINTS, Truth
from .machine import FACTORS, TIME_SHIFT, rest_mass
from .simulate import SAMPLE_HZ

STEP = time_from_si(1.0 / SAMPLE_HZ)
#: Directions that are this much weaker than the strongest count as none: drive gain against inertia, stiffness and damping together.
RANK = 1e-5


@dataclass(frozen=True, slots=True)
class Scale:
    """What turns a run into floors.

    Attributes:
        angle, tip: floors, rad and m.
        tips: tips count as a channel.
    """

    angle: float
    tip: float
    tips: bool

    def __call__(self, angles: np.ndarray, tips: np.ndarray) -> np.ndarray:
        """(n, 2 or 4) in floors."""
        return np.hstack([angles / self.angle, tips / self.tip]) if self.tips else angles / self.angle

    def run(self, run: Truth) -> np.ndarray:
        """(n, 2 or 4) channels of a run in floors."""
        return self(run.angles, run.tips)


@dataclass(frozen=True, slots=True)
class Directions:
    """What small changes of parameters do to a run.

    Attributes:
        names: keys of the changes, "kind.joint".
        basis: (rows, rank) orthonormal.
        solve: (len(names), rank) changes per basis coefficient.
    """

    names: tuple[str, ...]
    basis: np.ndarray
    solve: np.ndarray

    def project(self, residual: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What is left of a residual (n, channels), and the changes that take the rest away."""
        flat = residual.ravel()
        share = self.basis.T @ flat
        return (flat - self.basis @ share).reshape(residual.shape), self.solve @ share


def directions(run: Truth, scale: Scale) -> Directions:
    """Of the parameters named above, about a run of the leg without the effect."""
    front = simple_constants()["front"]
    q, u = run.angles, run.volts - value("actuator.neutral_voltage")
    rate = np.gradient(q, STEP, axis=0)
    forces = {
        "drive_gain": np.array(front["torque_per_volt"]) * u,
        "stiffness": -np.array(front["stiffness"]) * q,
        "damping": -np.array(front["damping"]) * rate,
        "inertia": -np.diag(rest_mass()) * np.gradient(rate, STEP, axis=0),
        "preload": np.ones_like(q),
    }
    ratio = length_to_si(np.array(front["tip_per_angle"]))
    names, columns = [], []
    for kind, force in forces.items():
        for i, joint in enumerate(JOINTS):
            moved = _respond(np.where(np.arange(2) == i, force, 0.0))
            names.append(f"{kind}.{joint}")
            columns.append(scale(moved, moved * ratio))
    one, none = np.ones_like(q), np.zeros_like(q)
    for kind, on_angle, on_tip in (
        ("sensor_gain", q, none), ("bias", one, none), ("tip_gain", none, run.tips), ("tip_bias", none, length_to_si(one)),
    ):  # fmt: skip
        for i, joint in enumerate(JOINTS):
            pick = np.arange(2) == i
            names.append(f"{kind}.{joint}")
            columns.append(scale(np.where(pick, on_angle, 0.0), np.where(pick, on_tip, 0.0)))
    names.append(TIME_SHIFT)
    columns.append(scale(-rate, -np.gradient(run.tips, STEP, axis=0)))
    return _orthogonal(tuple(names), np.stack([column.ravel() for column in columns], axis=1))


def retuned_gap(
    truth: Truth, model: Callable[[Mapping[str, float]], Truth], start: Mapping[str, float], around: Directions, scale: Scale, *, steps: int
) -> float:
    """Rms in floors of truth minus the best model(changes), from `start` with at most `steps` further simulations."""
    changes, left, reached = start, np.inf, np.inf
    for _ in range(steps + 1):
        rest, move = around.project(scale.run(truth) - scale.run(model(changes)))
        before, left = left, float(np.sqrt(np.mean(rest**2)))
        reached = min(reached, left)
        if abs(left - before) < 0.01 * left:
            break
        changes = _moved(changes, dict(zip(around.names, move.tolist(), strict=True)))
    return reached


def _moved(changes: Mapping[str, float], by: Mapping[str, float]) -> dict[str, float]:
    """Factors take at most a third at a time, and never turn negative."""
    moved = dict(changes)
    for name, step in by.items():
        if name.split(".")[0] in FACTORS:
            moved[name] = moved.get(name, 1.0) * (1.0 + float(np.clip(step, -0.33, 0.33)))
        else:
            moved[name] = moved.get(name, 0.0) + step
    return moved


def _orthogonal(names: tuple[str, ...], columns: np.ndarray) -> Directions:
    size = np.linalg.norm(columns, axis=0)
    size[size == 0.0] = 1.0
    columns /= size
    values, vectors = np.linalg.eigh(columns.T @ columns)
    kept = values > RANK**2 * values[-1]
    turn = vectors[:, kept] / np.sqrt(values[kept])
    return Directions(names, columns @ turn, turn / size[:, None])


def _respond(force: np.ndarray) -> np.ndarray:
    """Answer (n, 2) rad of the linear leg to torques (n, 2) N mm, straight between samples."""
    front, mass = simple_constants()["front"], np.linalg.inv(rest_mass())
    a = np.block([[np.zeros((2, 2)), np.eye(2)], [-mass @ np.diag(front["stiffness"]), -mass @ np.diag(front["damping"])]])
    whole = np.zeros((8, 8))
    whole[:4, :4], whole[2:4, 4:6], whole[4:6, 6:] = a * STEP, mass * STEP, np.eye(2)
    e = expm(whole)
    return _march(*map(np.ascontiguousarray, (e[:4, :4], e[:4, 4:6] - e[:4, 6:], e[:4, 6:])), force)


@njit(cache=True)
def _march(a, now, then, force):
    out, x = np.zeros(force.shape), np.zeros(4)
    for k in range(len(force) - 1):
        x = a @ x + now @ force[k] + then @ force[k + 1]
        out[k + 1] = x[:2]
    return out
