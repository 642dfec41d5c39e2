"""The bank of effects in the kernels of the whole robot: more rows, two more stages, and a leg function with effects in it.

In each step, `sense` makes of the angles what sensors say (the leg law sees that), `command` makes of the drive what acts, and the
leg function adds forces, springs, dampers and inertia. Places are 0 and 1 for a leg's swing and lift. More rows of the arrays:
    state  DRIVE: the drive that acts, and memories; FORCE: slip of the actuators' side, its rate, time, and memories;
           SENSE: error of the readings, and memories
    param  a leg's own stiffness and inertia at rest, re-tuned parameters, parameters of effects
    body   pull of gravity along the ground, parameters of what tows the chassis
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

from . import vec
from .effects.bank import ACTS, Acting, Bank, Equations
from .effects.law import Motion, Scales
from .emit import Stage, rows
from .leg import Leg
from .plant import Plant

LEG_BANK = Bank(2, (*ACTS, "leg"))
#: What is usual for a leg under a few ten volts: only for shapes of effects whose sizes are zero. N mm, rad, ms, V, ms.
USUAL = Scales(0.06, 0.1, 2.0, 40.0, 12e3)

REST = rows(rest_stiffness=2, rest_inertia=2)
POSE = rows(pull=3, tow=3)
NEAR = rows(pull=3)
MEASURED = tuple(f"measured.{row}" for row in rows(q=2, v=2))
Laws = frozenset[tuple[str, str]] | None  # (effect, form) that kernels carry; None: all


@dataclass(frozen=True, slots=True)
class Carried:
    """The banks of some laws, and their rows.

    Attributes:
        leg, chassis. drive, force, sense: rows of the state. parameters: of a lane. body: of the chassis.
    """

    leg: Bank
    chassis: Bank
    drive: tuple[str, ...]
    force: tuple[str, ...]
    sense: tuple[str, ...]
    parameters: tuple[str, ...]
    body: tuple[str, ...]

    @property
    def state(self) -> tuple[str, ...]:
        """All rows of the state."""
        return (*self.drive, *self.force, *self.sense)

    @property
    def first(self) -> dict[str, int]:
        """Where outputs begin in `state`."""
        return {"new_drive": 0, "new_force": len(self.drive), "new_sense": len(self.drive) + len(self.force)}


@cache
def carried(laws: Laws = None) -> Carried:
    """Banks and rows of some laws."""
    leg, chassis = replace(LEG_BANK, laws=laws), Bank(0, ("tow",), laws)
    return Carried(
        leg, chassis, drive=(*rows(acted=2), *leg.state_rows("drive")),
        force=(*rows(slip=2, slip_rate=2, time=1), *leg.state_rows("force", "pair")), sense=(*rows(error=2), *leg.state_rows("sense")),
        parameters=(*REST, *leg.parameter_rows), body=(*rows(pull=2), *chassis.parameter_rows),
    )  # fmt: skip


def command(state: tuple[str, ...], param: tuple[str, ...], h: float, laws: Laws = None) -> Stage:
    """The drive that acts, of the commanded one; state and param are all rows of these arrays."""
    stage = Stage("command", {"state": state, "drive": rows(drive=2), "param": param}, {"new_drive": carried(laws).drive})
    acting = Acting(carried(laws).leg, stage, "new_drive")
    stage.write("new_drive", "acted", acting.drive(stage.reads("drive", "drive", 2), stage.read("state", "time"), h))
    return stage


def sense(state: tuple[str, ...], param: tuple[str, ...], h: float, laws: Laws = None) -> Stage:
    """What the sensors say of angles and rates, as the first rows of a state; arguments as of `command`."""
    stage = Stage("sense", {"state": state, "param": param}, {"new_sense": carried(laws).sense, "measured": rows(q=2, v=2)})
    q, v, error = _reading(stage, h, "new_sense", laws)
    stage.write("measured", "q", q)
    stage.write("measured", "v", v)
    stage.write("new_sense", "error", error)
    return stage


def _reading(stage: Stage, h: float, new: str, laws: Laws) -> tuple[tuple, tuple, tuple]:
    """Measured angles, rates (the true ones plus the rate of the sensors' error), and that error."""
    q, v = stage.reads("state", "q", 2), stage.reads("state", "v", 2)
    angle = Acting(carried(laws).leg, stage, new).sense(q, h)
    error = vec.sub(angle, q)
    change = vec.sub(error, stage.reads("state", "error", 2))
    return angle, vec.add(v, vec.scale(change, 1.0 / h)), error


def leg(plant: Plant, stage: Stage, h: float) -> Callable:
    """The plant's leg function with all that acts on a leg; memories go to "new_force"."""
    acting = Acting(carried(plant.laws).leg, stage, "new_force")
    time, before = stage.read("state", "time"), stage.reads("state", "slip", 2)
    rest = {name: stage.reads("param", f"rest_{name}", 2) for name in ("stiffness", "inertia")}

    def function(q, v, drive, parameters) -> Leg:
        now = parameters | {"step": h}  # as in a machine, whose stops are touched for a part of a step
        at = acting.leg(plant.leg(q, v, drive, now))
        idle = acting.leg(plant.leg(q, v, (0.0, 0.0), now))
        equations = Equations(list(at.force), [0.0] * 3, list(at.stiffness), list(at.damping), [0.0] * 2)
        acting.push(equations, q, v, vec.sub(at.torque, idle.torque), rest["stiffness"], rest["inertia"], time, h)
        slip = tuple(equations.slip)
        stage.write("new_force", "slip", slip)
        stage.write("new_force", "slip_rate", vec.scale(vec.sub(slip, before), 1.0 / h))
        stage.write("new_force", "time", time + h)
        matrices = {"stiffness": tuple(equations.stiffness), "damping": tuple(equations.damping), "armature": tuple(equations.mass)}
        return replace(at, force=tuple(equations.force), **matrices)

    return function


def seen(stage: Stage, at: Leg, h: float, laws: Laws) -> Leg:
    """A leg as effects scale it; writes what a simulator and its sensors see of it."""
    at = Acting(carried(laws).leg, stage, "").leg(at)
    angle, angle_rate, _ = _reading(stage, h, "", laws)
    stage.write("seen", "measured.q", angle)
    stage.write("seen", "measured.v", angle_rate)
    return at


def tips(stage: Stage, at: Leg, v: tuple) -> tuple[tuple, tuple]:
    """Tips and their rates, ahead of the joints by the slip of the actuators' side."""
    slip, slip_rate = stage.reads("state", "slip", 2), stage.reads("state", "slip_rate", 2)
    tip, rate = [], []
    for i, t in enumerate(at.tips):
        slope = t.dd[i] * v[0] + t.dd[i + 1] * v[1]
        tip.append(t.value + t.d[i] * slip[i])
        rate.append(t.rate(v) + t.d[i] * slip_rate[i] + slope * slip[i])
    return tuple(tip), tuple(rate)


def surroundings(stage: Stage, state, matrix: tuple, laws: Laws) -> tuple:
    """Writes pull and tow in the chassis's axes, for a base state and the rows of its rotation; the pull."""
    x, y = stage.reads("body", "pull", 2)
    force = Acting(carried(laws).chassis, stage, "", "body").tow(Motion(state.position, state.velocity))
    pull = vec.add(vec.scale(matrix[0], x), vec.scale(matrix[1], y))
    stage.write("pose", "pull", pull)
    stage.write("pose", "tow", tuple(sum((matrix[i][k] * force[i] for i in range(3)), 0.0) for k in range(3)))
    return pull
