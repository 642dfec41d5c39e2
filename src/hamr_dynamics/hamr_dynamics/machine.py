"""A machine of one or two coupled joints, one drive each, with every effect of the library built in and switched off.

HAMR's suspended leg is one; any other machine can be (`linear_machine`, or `Machine` itself). The step is the linearly implicit
midpoint rule of `step`; effects and the re-tunable parameters (`CHANGES`) are rows that differ from lane to lane.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hamr_description.errors import ConfigError

from .effects.bank import ACTS, CHANGES, Acting, Bank, Equations
from .effects.law import Form, Scales
from .emit import Stage
from .leg import inertia
from .plant import Plant
from .step import inverse2, times2

__all__ = ["CHANGES", "Machine", "Terms", "leg_machine", "linear_machine", "step_stage"]

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
    """

    name: str
    joints: tuple[str, ...]
    channels: tuple[str, ...]
    terms: Callable
    outputs: Callable
    units: Mapping[str, str]
    to_si: Mapping[str, float]

    def __post_init__(self) -> None:
        if len(self.joints) not in (1, 2):
            raise ConfigError(f"Machine '{self.name}' has {len(self.joints)} joints: one or two are possible, split a larger one.")

    @cached_property
    def at_rest(self) -> Terms:
        """Terms at zero, as floats."""
        zero = (0.0,) * len(self.joints)
        return self.terms(zero, zero, zero, zero)

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

def step_stage(machine: Machine) -> Stage:
    """The traced step: state, drive and parameters -> new state, and the readings at its start."""
    n = len(machine.joints)
    drives = tuple(f"u.{j}" for j in range(n))
    stage = Stage(
        "machine_step", {"state": machine.state_rows, "drive": drives, "param": machine.parameter_rows},
        {"new_state": machine.state_rows, "seen": tuple(f"y.{c}" for c in range(len(machine.channels)))},
    )  # fmt: skip
    q, v, a, slip = (tuple(stage.read("state", f"{x}.{j}") for j in range(n)) for x in ("q", "v", "a", "slip"))
    time, h = stage.read("state", "time"), stage.read("param", "step")
    bank = Acting(machine.bank, stage)

    u = bank.drive(tuple(stage.read("drive", d) for d in drives), time, h)
    middle = tuple(x + (0.5 * h) * y for x, y in zip(q, v, strict=True))
    v_mid = tuple(y + (0.5 * h) * z for y, z in zip(v, a, strict=True))
    terms = machine.terms(middle, v_mid, v, u)
    force = [x - b for x, b in zip(terms.force, terms.bias, strict=True)]
    equations = Equations(force, list(terms.mass), list(terms.stiffness), list(terms.damping), [0.0] * n)
    stiff, heavy = ([machine.diagonal(x, j) for j in range(n)] for x in (machine.at_rest.stiffness, machine.at_rest.mass))
    bank.push(equations, middle, v, terms.drive, stiff, heavy, time, h)

    matrices = zip(equations.mass, equations.damping, equations.stiffness, strict=True)
    left = tuple(m + (0.5 * h) * d + (0.25 * h * h) * k for m, d, k in matrices)
    kick = tuple(h * f for f in equations.force)
    increment = times2(inverse2(left), kick) if n == 2 else (kick[0] / left[0],)
    v_new = tuple(x + y for x, y in zip(v, increment, strict=True))
    _write(stage, "new_state", "q", [x + (0.5 * h) * (y + z) for x, y, z in zip(q, v, v_new, strict=True)])
    _write(stage, "new_state", "v", v_new)
    _write(stage, "new_state", "a", [x / h for x in increment])
    _write(stage, "new_state", "slip", equations.slip)
    stage.write("new_state", "time", time + h)

    outputs = machine.outputs(q, slip)
    seen = (*bank.sense(outputs[:n], h), *outputs[n:])
    _write(stage, "seen", "y", seen)
    return stage

def _write(stage: Stage, array: str, name: str, values) -> None:
    for i, x in enumerate(values):
        stage.write(array, f"{name}.{i}", x)

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

    def terms(q, v_mid, v, u) -> Terms:
        at = plant.leg(q, v, u, parameters)
        idle = plant.leg(q, v, (0.0, 0.0), parameters)
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
    return Machine(f"{plant.name}_{leg}", joints, (*joints, *(f"{j}_actuator" for j in joints)), terms, outputs, units, si)

