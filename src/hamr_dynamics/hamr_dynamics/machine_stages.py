"""The step of a machine in parts: its own equations, and every law of the bank by itself, so that a law that no lane uses can be left out.

The step is the linearly implicit midpoint rule of `step`. Parts share nothing but rows of the arrays, so that any law can be missing.

Arrays (rows x lanes); an output new_X lies on X, `memory` on a law's internal states in `state`:
    state  as `Machine.state_rows`;  param  as `Machine.parameter_rows`
    drive  commanded at first; drive laws bend it
    equations  force, matrices and slip at the middle of the step, and the drive's share of the force; force laws add to it
    seen  readings at the start of the step; sense laws bend those of the joints
"""

from __future__ import annotations

from .effects.bank import Acting, Equations, Law
from .emit import Part, Stage
from .machine import Machine
from .step import inverse2, times2


def arrays(machine: Machine) -> dict[str, tuple[str, ...]]:
    """Array -> names of its rows."""
    n = len(machine.joints)
    return {
        "state": machine.state_rows,
        "param": machine.parameter_rows,
        "drive": tuple(f"u.{j}" for j in range(n)),
        "equations": tuple(f"{name}.{i}" for name, size in (Equations.sizes(n) | {"drive": n}).items() for i in range(size)),
        "seen": tuple(f"y.{c}" for c in range(len(machine.channels))),
    }


def parts(machine: Machine) -> list[Part]:
    """The whole step, in order."""
    drive, force, pair, sense = ([_law(machine, law) for law in machine.bank.of(kind)] for kind in ("drive", "force", "pair", "sense"))
    return [Part(_gain(machine)), *drive, Part(_terms(machine)), *force, *pair, Part(_solve(machine)), *sense]


def _stage(machine: Machine, name: str, *outputs: str, memory: tuple[str, ...] = ()) -> Stage:
    """A stage from all arrays to some; rows of a new_X that it does not write stay as they are."""
    rows = arrays(machine)
    inputs = {array: names for array, names in rows.items() if array not in outputs}
    stage = Stage(name, inputs, {array: rows[array.removeprefix("new_")] for array in outputs} | {"memory": memory})
    for array in outputs:
        old = array.removeprefix("new_")
        if old != array:
            for row in rows[old]:
                stage.write(array, row, stage.read(old, row))
    return stage


def _gain(machine: Machine) -> Stage:
    stage = _stage(machine, "gain", "new_drive")
    stage.write("new_drive", "u", Acting(machine.bank, stage).gained(stage.reads("drive", "u", len(machine.joints))))
    return stage


def _terms(machine: Machine) -> Stage:
    stage, n = _stage(machine, "terms", "equations"), len(machine.joints)
    q, v, h = _middle(machine, stage)
    v_mid = tuple(x + (0.5 * h) * y for x, y in zip(v, stage.reads("state", "a", n), strict=True))
    terms = machine.terms(q, v_mid, v, stage.reads("drive", "u", n), *([h] if machine.stepped else []))
    force = [x - b for x, b in zip(terms.force, terms.bias, strict=True)]
    equations = Equations(force, list(terms.mass), list(terms.stiffness), list(terms.damping), [0.0] * n)
    Acting(machine.bank, stage).changed(equations, q, v)
    equations.write(stage, "equations")
    stage.write("equations", "drive", tuple(terms.drive))
    return stage


def _solve(machine: Machine) -> Stage:
    stage, n = _stage(machine, "solve", "new_state", "seen"), len(machine.joints)
    q, v, h = stage.reads("state", "q", n), stage.reads("state", "v", n), stage.read("param", "step")
    equations = Equations.read(stage, n)
    matrices = zip(equations.mass, equations.damping, equations.stiffness, strict=True)
    left = tuple(m + (0.5 * h) * d + (0.25 * h * h) * k for m, d, k in matrices)
    kick = tuple(h * f for f in equations.force)
    increment = times2(inverse2(left), kick) if n == 2 else (kick[0] / left[0],)
    v_new = tuple(x + y for x, y in zip(v, increment, strict=True))
    stage.write("new_state", "q", tuple(x + (0.5 * h) * (y + z) for x, y, z in zip(q, v, v_new, strict=True)))
    stage.write("new_state", "v", v_new)
    stage.write("new_state", "a", tuple(x / h for x in increment))
    stage.write("new_state", "slip", tuple(equations.slip))
    stage.write("new_state", "time", stage.read("state", "time") + h)
    readings = machine.outputs(q, stage.reads("state", "slip", n))
    # at the start of the step, half way from the middle of the one before
    halfway = tuple(0.5 * (x / h + y) for x, y in zip(increment, stage.reads("state", "a", n), strict=True)) if machine.moving else ()
    stage.write("seen", "y", (*readings, *v, *halfway) if machine.moving else tuple(readings))
    return stage


def _law(machine: Machine, law: Law) -> Part:
    """A law at all its places."""
    name, form = law
    act, output = _ACTS[form.acts]
    stage = _stage(machine, f"{name}_{form.name}", output, memory=machine.bank.memory(law))
    act(machine, stage, law)
    return machine.bank.part(law, stage, machine.state_rows, machine.parameter_rows)


def _bend_drive(machine: Machine, stage: Stage, law: Law) -> None:
    u, time, h = stage.reads("drive", "u", len(machine.joints)), stage.read("state", "time"), stage.read("param", "step")
    stage.write("new_drive", "u", Acting(machine.bank, stage, "memory").driven(law, u, time, h))


def _push(machine: Machine, stage: Stage, law: Law) -> None:
    q, v, h = _middle(machine, stage)
    joints = range(len(machine.joints))
    stiffness, inertia = (tuple(machine.diagonal(x, j) for j in joints) for x in (machine.at_rest.stiffness, machine.at_rest.mass))
    acting, equations = Acting(machine.bank, stage, "memory"), Equations.read(stage, len(joints))
    at = acting.around(q, v, stage.reads("equations", "drive", len(joints)), stiffness, inertia, h)
    acting.pushed(law, equations, at, stage.read("state", "time"))
    equations.write(stage, "new_equations")


def _bend_reading(machine: Machine, stage: Stage, law: Law) -> None:
    readings = stage.reads("seen", "y", len(machine.joints))
    stage.write("new_seen", "y", Acting(machine.bank, stage, "memory").sensed(law, readings, stage.read("param", "step")))


#: Kind of form -> what traces it, and the array that it changes.
_ACTS = {
    "drive": (_bend_drive, "new_drive"), "force": (_push, "new_equations"), "pair": (_push, "new_equations"),
    "sense": (_bend_reading, "new_seen"),
}  # fmt: skip


def _middle(machine: Machine, stage: Stage) -> tuple[tuple, tuple, object]:
    """Coordinates half a step ahead, rates at the start, step."""
    n, h = len(machine.joints), stage.read("param", "step")
    q, v = stage.reads("state", "q", n), stage.reads("state", "v", n)
    return tuple(x + (0.5 * h) * y for x, y in zip(q, v, strict=True)), v, h
