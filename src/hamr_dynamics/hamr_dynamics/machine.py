"""A machine of one or two coupled joints, one drive each, with every effect of the library built in and switched off.

HAMR's suspended leg is one; any other machine can be (`linear_machine`, or `Machine` itself). Effects and the re-tunable parameters
(`CHANGES`) are rows that differ from lane to lane; `machine_stages` has the step.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from hamr_description.errors import ConfigError

from .effects.bank import ACTS, CHANGES, Bank
from .effects.law import Form, Scales
from .leg import inertia
from .plant import Plant

__all__ = ["CHANGES", "Machine", "Terms", "leg_machine", "linear_machine", "with_motion"]

MOTION = ("rate", "acceleration")  # first and second derivative of a coordinate

@dataclass(frozen=True, slots=True)
class Terms:
    """Equations of motion at a point: mass a + bias = force; matrices of two joints as (11, 12, 22), of one as (11,).

    Attributes:
        mass, bias (n,), force (n,): of everything but effects. stiffness, damping: -d force/dq, -d force/dv.
        drive: (n,) the drive's share of force.
    """

    mass: tuple
    bias: tuple
    force: tuple
    stiffness: tuple
    damping: tuple
    drive: tuple

@dataclass(frozen=True, eq=False)
class Machine:
    """A model of the machine without any effect.

    Attributes:
        name: also of the compiled kernel. joints: one or two names. channels: names of the sensor channels; the first are the joints' own.
        terms: (q, v_mid, v, u) -> Terms, pure, over any scalar type.
        outputs: (q, slip) -> readings of the channels.
        units: unit of F, Q, T and U, for reports.
        to_si: factor to these units, of F, Q, T, U.
        stepped: whether `terms` also takes the step (T), as stops do that are touched for a part of it.
        moving: whether the last channels are the joints' rates and accelerations (`with_motion`), of which `outputs` knows nothing.
    """

    name: str
    joints: tuple[str, ...]
    channels: tuple[str, ...]
    terms: Callable
    outputs: Callable
    units: Mapping[str, str]
    to_si: Mapping[str, float]
    moving: bool = False
    stepped: bool = False

    def __post_init__(self) -> None:
        if len(self.joints) not in (1, 2):
            raise ConfigError(f"Machine '{self.name}' has {len(self.joints)} joints: one or two are possible, split a larger one.")

    @cached_property
    def at_rest(self) -> Terms:
        """Terms at zero, as floats."""
        zero = (0.0,) * len(self.joints)
        return self.terms(zero, zero, zero, zero)

    def motion_of(self, channel: str) -> tuple[int, int] | None:
        """(joint, how many times its coordinate is differentiated) that a channel reads; None of what is no joint's motion."""
        at, n = self.channels.index(channel), len(self.joints)
        if at < n:
            return at, 0
        further = at - (len(self.channels) - len(MOTION) * n)
        return (further % n, 1 + further // n) if self.moving and further >= 0 else None

    def diagonal(self, matrix: tuple, i: int):
        """Entry ii of a matrix of `Terms`."""
        return matrix[(0, 2)[i]] if len(self.joints) == 2 else matrix[0]

    @property
    def bank(self) -> Bank:
        """Every effect that can act on this machine."""
        return Bank(len(self.joints))

    @property
    def forms(self) -> list[tuple[str, Form]]:
        """(effect name, form) of all that can act on this machine, in order of action."""
        return self.bank.forms

    def places(self, form: Form) -> range:
        """Indices of the places a form has: joints, or the pair."""
        return self.bank.places(form)

    @cached_property
    def parameter_rows(self) -> tuple[str, ...]:
        """Names of what may differ between lanes, all zero when nothing is added: change.NAME.JOINT, EFFECT.FORM.PARAMETER.PLACE, step."""
        return (*self.bank.parameter_rows, "step")

    def neutral(self, scales: Scales) -> np.ndarray:
        """(rows,) with nothing changed and no effect: sizes zero, shapes at their typical value."""
        return np.append(self.bank.neutral(scales), 0.0)

    @cached_property
    def state_rows(self) -> tuple[str, ...]:
        """Names of the state: q, v, a, slip of each joint, time, and the effects' own."""
        own = [f"{x}.{j}" for x in ("q", "v", "a", "slip") for j in range(len(self.joints))]
        return (*own, "time", *self.bank.state_rows(*ACTS))

def with_motion(machine: Machine) -> Machine:
    """The same with sensors of rate and acceleration besides: channels NAME_rate and NAME_acceleration of each joint's own channel NAME."""
    own = machine.channels[: len(machine.joints)]
    return replace(machine, channels=(*machine.channels, *(f"{name}_{kind}" for kind in MOTION for name in own)), moving=True)

def linear_machine(
    name: str, *, inertia: float, stiffness: float = 0.0, damping: float = 0.0, gain: float = 1.0, preload: float = 0.0,
    joint: str = "joint", units: Mapping[str, str] | None = None,
) -> Machine:  # fmt: skip
    """One joint: inertia a = gain u - stiffness q - damping v + preload, in any consistent units (SI, seconds, unless said)."""

    def terms(q, v_mid, v, u) -> Terms:
        drive = gain * u[0]
        force = drive + preload - stiffness * q[0] - damping * v[0]
        return Terms((inertia,), (0.0,), (force,), (stiffness,), (damping,), (drive,))

    si = {"F": 1.0, "Q": 1.0, "T": 1.0, "U": 1.0}
    return Machine(name, (joint,), (joint,), terms, lambda q, slip: (q[0],), units or {"F": "N", "Q": "m", "T": "s", "U": "V"}, si)

def leg_machine(plant: Plant, leg: str, *, gravity: float) -> Machine:
    """A suspended leg of a plant in the mirrored front-left frame; channels are its hip angles (rad) and actuator tips (mm)."""
    parameters = plant.parameters(leg)

    def terms(q, v_mid, v, u, step=None) -> Terms:
        now = parameters | {"step": step}
        at = plant.leg(q, v, u, now)
        idle = plant.leg(q, v, (0.0, 0.0), now)
        weight = inertia(at.bodies, v_mid, (0.0, 0.0, 0.0), (0.0, 0.0, gravity))
        drive = tuple(x - y for x, y in zip(at.torque, idle.torque, strict=True))
        return Terms(weight.leg, weight.leg_bias, at.force, at.stiffness, at.damping, drive)

    def outputs(q, slip):
        tips = plant.leg(q, (0.0, 0.0), (0.0, 0.0), parameters).tips
        # the actuator's side runs ahead of the joint by `slip` (of its angle)
        return (*q, *(t.value + t.d[i] * slip[i] for i, t in enumerate(tips)))

    joints = (f"{leg}_swing", f"{leg}_lift")
    si = {"F": 1e-3, "Q": 1.0, "T": 1e-3, "U": 1.0}
    units = {"F": "N*m", "Q": "rad", "T": "s", "U": "V"}
    return Machine(f"{plant.name}_{leg}", joints, (*joints, *(f"{j}_actuator" for j in joints)), terms, outputs, units, si, stepped=True)

