"""The bank of effects in the kernels of the whole robot: more rows, and more parts of the step.

In each step, the parts of `sense` make of the angles what sensors say (the leg law sees that), those of `command` make of the drive what
acts, and those of `forces` a leg's own equations and what effects add to them. Every law is a part by itself, so that one that no lane
uses can be left out. Places are 0 and 1 for a leg's swing and lift. More rows of the arrays:
    state  the drive that acts, slip of the actuators' side, its rate, time, error of the readings; then memories of laws
    param  a leg's own stiffness and inertia at rest, re-tuned parameters, parameters of effects
    body   pull of gravity along the ground, parameters of what tows the chassis
and two arrays more:
    signal     what the sensors say, of angles
    equations  of a leg at the middle of the step, and the drive's share of the force
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from . import vec
from .effects.bank import ACTS, Acting, Bank, Equations, Law
from .effects.law import Motion, Scales
from .emit import Part, Stage, rows
from .leg import Leg
from .plant import Plant

LEG_BANK, CHASSIS_BANK = Bank(2, (*ACTS, "leg")), Bank(0, ("tow",))
#: What is usual for a leg under a few ten volts: only for shapes of effects whose sizes are zero. N mm, rad, ms, V, ms.
USUAL = Scales(0.06, 0.1, 2.0, 40.0, 12e3)

REST = rows(rest_stiffness=2, rest_inertia=2)
ACTED, MOVED, ERROR = rows(acted=2), rows(slip=2, slip_rate=2, time=1), rows(error=2)
STATE = (*ACTED, *MOVED, *ERROR, *LEG_BANK.state_rows(*ACTS))
PARAMETERS = (*REST, *LEG_BANK.parameter_rows)
BODY = (*rows(pull=2), *CHASSIS_BANK.parameter_rows)
POSE = rows(pull=3, tow=3)
NEAR = rows(pull=3)
SIGNAL = rows(y=2)
EQUATIONS = rows(**Equations.sizes(2), drive=2)
MEASURED = tuple(f"measured.{row}" for row in rows(q=2, v=2))
#: Outputs that take the place of an input: output -> (input, first row); those in `state` are counted from the bank's first.
RENEWED = {array: ("state", STATE.index(own[0])) for array, own in (("acted", ACTED), ("moved", MOVED), ("error", ERROR))}
RENEWED |= {"new_signal": ("signal", 0), "new_equations": ("equations", 0)}
Rows = dict[str, tuple[str, ...]]  # of "state" and "param", all of them


def sense(arrays: Rows, h: float) -> list[Part]:
    """What the sensors say of angles and rates, as "measured", the first rows of a state."""
    begin = Stage("sense", {"state": arrays["state"]}, {"signal": SIGNAL})
    begin.write("signal", "y", begin.reads("state", "q", 2))
    laws = [_law(law, arrays, {"signal": SIGNAL}, "new_signal", _bend_reading, h) for law in LEG_BANK.of("sense")]
    end = Stage("sensed", arrays | {"signal": SIGNAL}, {"error": ERROR, "measured": rows(q=2, v=2)})
    q, v, error = _reading(end, end.reads("signal", "y", 2), h)
    end.write("measured", "q", q)
    end.write("measured", "v", v)
    end.write("error", "error", error)
    return [Part(begin), *laws, Part(end)]


def command(arrays: Rows, drive: tuple[str, ...], h: float) -> list[Part]:
    """The drive that acts, of the commanded one."""
    gain = Stage("command", arrays | {"drive": drive}, {"acted": ACTED})
    gain.write("acted", "acted", Acting(LEG_BANK, gain).gained(gain.reads("drive", "drive", 2)))
    return [Part(gain), *(_law(law, arrays, {}, "acted", _bend_drive, h) for law in LEG_BANK.of("drive"))]


def forces(plant: Plant, arrays: Rows, drive: tuple[str, ...], ahead: Callable, parameters: Callable, h: float) -> list[Part]:
    """A leg's equations with all that acts on it.

    Args:
        ahead: a stage -> angles half a step ahead and rates (2,). parameters: a stage -> the plant's parameters.
    """
    stage = Stage("forces", arrays | {"drive": drive}, {"equations": EQUATIONS})
    q, v = ahead(stage)
    at = _at(plant, stage, q, v, stage.reads("drive", "drive", 2), parameters(stage), h)
    idle = _at(plant, stage, q, v, (0.0, 0.0), parameters(stage), h)
    equations = Equations(list(at.force), list(at.armature), list(at.stiffness), list(at.damping), [0.0] * 2)
    Acting(LEG_BANK, stage).changed(equations, q, v)
    equations.write(stage, "equations")
    stage.write("equations", "drive", vec.sub(at.torque, idle.torque))

    def push(stage: Stage, law: Law, h: float) -> None:
        acting, equations, (q, v) = Acting(LEG_BANK, stage, "memory"), Equations.read(stage, 2), ahead(stage)
        stiffness, inertia = (stage.reads("param", f"rest_{name}", 2) for name in ("stiffness", "inertia"))
        around = acting.around(q, v, stage.reads("equations", "drive", 2), stiffness, inertia, h)
        acting.pushed(law, equations, around, stage.read("state", "time"))
        equations.write(stage, "new_equations")
        stage.write("new_equations", "drive", stage.reads("equations", "drive", 2))

    own = {"equations": EQUATIONS}
    return [Part(stage), *(_law(law, arrays, own, "new_equations", push, h) for law in LEG_BANK.of("force", "pair"))]


def leg(plant: Plant, stage: Stage, h: float) -> Callable:
    """The plant's leg function with the equations that `forces` made; what has moved goes to "moved"."""
    equations, before = Equations.read(stage, 2), stage.reads("state", "slip", 2)
    slip = tuple(equations.slip)
    stage.write("moved", "slip", slip)
    stage.write("moved", "slip_rate", vec.scale(vec.sub(slip, before), 1.0 / h))
    stage.write("moved", "time", stage.read("state", "time") + h)
    matrices = {name: tuple(getattr(equations, name)) for name in ("force", "stiffness", "damping")}

    def function(q, v, drive, parameters) -> Leg:
        return replace(_at(plant, stage, q, v, drive, parameters, h), armature=tuple(equations.mass), **matrices)

    return function


def _at(plant: Plant, stage: Stage, q: tuple, v: tuple, drive: tuple, parameters: dict, h: float) -> Leg:
    """The plant's leg as effects scale it; as in a machine, its stops are touched for a part of a step."""
    return Acting(LEG_BANK, stage).leg(plant.leg(q, v, drive, parameters | {"step": h}))


def seen(stage: Stage, at: Leg, h: float) -> Leg:
    """A leg as effects scale it; writes what a simulator and its sensors see of it."""
    acting = Acting(LEG_BANK, stage, "")
    angle, angle_rate, _ = _reading(stage, acting.sense(stage.reads("state", "q", 2), h), h)
    stage.write("seen", "measured.q", angle)
    stage.write("seen", "measured.v", angle_rate)
    return acting.leg(at)


def tips(stage: Stage, at: Leg, v: tuple) -> tuple[tuple, tuple]:
    """Tips and their rates, ahead of the joints by the slip of the actuators' side."""
    slip, slip_rate = stage.reads("state", "slip", 2), stage.reads("state", "slip_rate", 2)
    tip, rate = [], []
    for i, t in enumerate(at.tips):
        slope = t.dd[i] * v[0] + t.dd[i + 1] * v[1]
        tip.append(t.value + t.d[i] * slip[i])
        rate.append(t.rate(v) + t.d[i] * slip_rate[i] + slope * slip[i])
    return tuple(tip), tuple(rate)


def surroundings(stage: Stage, state, matrix: tuple) -> tuple:
    """Writes pull and tow in the chassis's axes, for a base state and the rows of its rotation; the pull."""
    x, y = stage.reads("body", "pull", 2)
    force = Acting(CHASSIS_BANK, stage, "", "body").tow(Motion(state.position, state.velocity))
    pull = vec.add(vec.scale(matrix[0], x), vec.scale(matrix[1], y))
    stage.write("pose", "pull", pull)
    stage.write("pose", "tow", tuple(sum((matrix[i][k] * force[i] for i in range(3)), 0.0) for k in range(3)))
    return pull


def _law(law: Law, arrays: Rows, own: Rows, output: str, act: Callable, h: float) -> Part:
    """A law at all its places, as a part that changes rows of an output."""
    name, form = law
    outputs = {"acted": ACTED, "new_signal": SIGNAL, "new_equations": EQUATIONS}
    stage = Stage(f"{name}_{form.name}", arrays | own, {output: outputs[output], "memory": LEG_BANK.memory(law)})
    act(stage, law, h)
    return LEG_BANK.part(law, stage, **arrays)


def _bend_reading(stage: Stage, law: Law, h: float) -> None:
    stage.write("new_signal", "y", Acting(LEG_BANK, stage, "memory").sensed(law, stage.reads("signal", "y", 2), h))


def _bend_drive(stage: Stage, law: Law, h: float) -> None:
    drive, time = stage.reads("state", "acted", 2), stage.read("state", "time")
    stage.write("acted", "acted", Acting(LEG_BANK, stage, "memory").driven(law, drive, time, h))


def _reading(stage: Stage, angle: tuple, h: float) -> tuple[tuple, tuple, tuple]:
    """Measured angles, rates (the true ones plus the rate of the sensors' error), and that error."""
    error = vec.sub(angle, stage.reads("state", "q", 2))
    change = vec.sub(error, stage.reads("state", "error", 2))
    return angle, vec.add(stage.reads("state", "v", 2), vec.scale(change, 1.0 / h)), error
