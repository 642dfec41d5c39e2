"""The bank: every form of the library at every place of one leg (or of a machine of one joint), its rows, and how it acts in a trace.

`machine` and the stages of the whole robot build on it, so that one implementation serves both.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..emit import Part, Stage
from ..vec import add
from .law import Form, Input, Joint, Motion, Pair, PairPush, Push, Scales, Signal
from .library import library

#: What a fair re-tune may change at each joint: relative drive gain; added stiffness F/Q, damping F T/Q, inertia F T^2/Q; preload F.
CHANGES = {"gain": "1", "stiffness": "F/Q", "damping": "F*T/Q", "inertia": "F*T^2/Q", "preload": "F"}
#: Kinds of forms that act inside a step, in the order in which they act.
ACTS = ("drive", "force", "pair", "sense")
Law = tuple[str, Form]  # effect name, one of its forms


@dataclass(frozen=True, slots=True)
class Bank:
    """All forms of some kinds at one machine: of one joint, of two coupled ones, or of none."""

    joints: int
    acts: tuple[str, ...] = ACTS

    @property
    def forms(self) -> list[Law]:
        """(effect name, form) in order of action."""
        acts = [kind for kind in self.acts if kind != "pair" or self.joints == 2]
        found = [(name, form) for name, effect in library().items() for form in effect.forms if form.acts in acts]
        return sorted(found, key=lambda item: item[1].order)

    def of(self, *acts: str) -> list[Law]:
        """Those of some kinds."""
        return [(name, form) for name, form in self.forms if form.acts in acts]

    def places(self, form: Form) -> range:
        """Indices of the places a form has: joints, or the whole."""
        return range(self.joints if form.acts in ("drive", "force", "sense") else 1)

    @property
    def parameter_rows(self) -> tuple[str, ...]:
        """Rows that may differ between lanes: change.NAME.JOINT, EFFECT.FORM.PARAMETER.PLACE."""
        changes = [f"change.{name}.{j}" for name in CHANGES for j in range(self.joints)]
        effects = [
            f"{name}.{form.name}.{parameter.name}.{place}"
            for name, form in self.forms for parameter in form.parameters for place in self.places(form)
        ]  # fmt: skip
        return (*changes, *effects)

    def state_rows(self, *acts: str) -> tuple[str, ...]:
        """Rows of the internal states of the forms of some kinds."""
        return tuple(row for law in self.of(*acts) for row in self.memory(law))

    def memory(self, law: Law) -> tuple[str, ...]:
        """Rows of the internal states of a law."""
        name, form = law
        return tuple(f"{name}.{form.name}.z{i}.{place}" for place in self.places(form) for i in range(form.states))

    def part(self, law: Law, stage: Stage, state: Sequence[str], param: Sequence[str]) -> Part:
        """A law, traced in a stage, as a part that is left out where its sizes are zero; `state`, `param`: all rows of these arrays."""
        name, form = law
        sizes = (f"{name}.{form.name}.{size.name}.{place}" for size in form.sizes for place in self.places(form))
        memory = self.memory(law)
        return Part(stage, tuple(map(param.index, sizes)), state.index(memory[0]) if memory else 0, f"{name}.{form.name}.")

    def neutral(self, scales: Scales) -> np.ndarray:
        """(rows,) with nothing changed and no effect: sizes zero, shapes at their typical value."""
        row = dict.fromkeys(self.parameter_rows, 0.0)
        for name, form in self.forms:
            for shape in form.shapes:
                for place in self.places(form):
                    row[f"{name}.{form.name}.{shape.name}.{place}"] = shape.typical * scales.of(shape.dimension)
        return np.array(list(row.values()))


@dataclass(slots=True)
class Equations:
    """A machine's equations of motion while effects are added.

    Attributes:
        force: (n,). mass, stiffness, damping: as (11, 12, 22) for two joints, (11,) for one. slip: (n,), see `law.Push`.
    """

    force: list
    mass: list
    stiffness: list
    damping: list
    slip: list

    @staticmethod
    def sizes(n: int) -> dict[str, int]:
        """Numbers in each field, of n joints."""
        matrix = 3 if n == 2 else 1
        return {"force": n, "mass": matrix, "stiffness": matrix, "damping": matrix, "slip": n}

    @classmethod
    def read(cls, stage: Stage, n: int) -> Equations:
        """Of n joints, from the rows of "equations"."""
        return cls(*(list(stage.reads("equations", name, size)) for name, size in cls.sizes(n).items()))

    def write(self, stage: Stage, array: str) -> None:
        """As rows of an array."""
        for name in self.sizes(len(self.force)):
            stage.write(array, name, tuple(getattr(self, name)))

    def diagonal(self, j: int) -> int:
        """Where entry jj of a matrix is."""
        return (0, 2)[j] if len(self.force) == 2 else 0

    def add(self, j: int, push: Push) -> None:
        """A push at joint j."""
        diagonal = self.diagonal(j)
        self.force[j] = self.force[j] + push.force
        self.mass[diagonal] = self.mass[diagonal] + push.mass
        self.stiffness[diagonal] = self.stiffness[diagonal] + push.stiffness
        self.damping[diagonal] = self.damping[diagonal] + push.damping
        self.slip[j] = self.slip[j] + push.slip

    def add_pair(self, push: PairPush) -> None:
        """A push at both joints."""
        for total, part in ((self.force, push.force), (self.mass, push.mass), (self.stiffness, push.stiffness),
                            (self.damping, push.damping), (self.slip, push.slip)):  # fmt: skip
            for i, x in enumerate(part):
                total[i] = total[i] + x


class Acting:
    """A bank at work in a stage with arrays `param` and "state"; new internal states go to the array `new`, or nowhere."""

    def __init__(self, bank: Bank, stage: Stage, new: str = "new_state", param: str = "param") -> None:
        self._bank, self._stage, self._new, self._param = bank, stage, new, param
        self._joints = range(bank.joints)

    def gained(self, u: tuple) -> tuple:
        """(n,) drive with the re-tuned gain."""
        return tuple(x + g * x for x, g in zip(u, self._change("gain"), strict=True))

    def driven(self, law: Law, u: tuple, time, step) -> tuple:
        """(n,) drive as one law leaves it."""
        return tuple(self._act(law, j, Input(u[j], u, j, time, step)) for j in self._joints)

    def around(self, q: tuple, v: tuple, drive: tuple, stiffness: tuple, inertia: tuple, step) -> Pair:
        """What forces see of all joints (two, or the only one); stiffness and inertia (n,) are the machine's own at rest, unchanged."""
        change = self._changes()
        stiff = tuple(x + y for x, y in zip(stiffness, change["stiffness"], strict=True))
        heavy = tuple(x + y for x, y in zip(inertia, change["inertia"], strict=True))
        return Pair(q, v, drive, stiff, heavy, step)

    def changed(self, equations: Equations, q: tuple, v: tuple) -> None:
        """Adds the re-tuned parameters."""
        change = self._changes()
        for j in self._joints:
            k, d = change["stiffness"][j], change["damping"][j]
            equations.add(j, Push(change["preload"][j] - k * q[j] - d * v[j], k, d, change["inertia"][j]))

    def pushed(self, law: Law, equations: Equations, at: Pair, time) -> None:
        """Adds one law, of forces at joints or of pairs."""
        if law[1].acts == "pair":
            equations.add_pair(self._act(law, 0, at))
            return
        for j in self._joints:
            own = (x[j] for x in (at.q, at.v, at.drive, at.stiffness, at.inertia))
            damping = equations.damping[equations.diagonal(j)]
            equations.add(j, self._act(law, j, Joint(*own, time, at.step, damping)))

    def leg(self, leg):
        """A `leg.Leg` as forms that act on it leave it."""
        for law in self._bank.of("leg"):
            leg = self._act(law, 0, leg)
        return leg

    def tow(self, motion: Motion) -> tuple:
        """(3,) force on the chassis."""
        total = (0.0, 0.0, 0.0)
        for law in self._bank.of("tow"):
            total = add(total, self._act(law, 0, motion))
        return total

    def sense(self, reading: tuple, step) -> tuple:
        """(n,) what the joints' sensors say."""
        for law in self._bank.of("sense"):
            reading = self.sensed(law, reading, step)
        return reading

    def sensed(self, law: Law, reading: tuple, step) -> tuple:
        """(n,) readings as one law leaves them."""
        return tuple(self._act(law, j, Signal(y, step)) for j, y in enumerate(reading))

    def _changes(self) -> dict[str, tuple]:
        return {name: self._change(name) for name in CHANGES}

    def _change(self, name: str) -> tuple:
        """(n,) of a re-tuned parameter."""
        return tuple(self._stage.read("param", f"change.{name}.{j}") for j in self._joints)

    def _act(self, law: Law, place: int, view):
        """What a law answers; it reads its parameters and states and writes the states back."""
        stage, (name, form) = self._stage, law
        p = {x.name: stage.read(self._param, f"{name}.{form.name}.{x.name}.{place}") for x in form.parameters}
        rows = [f"{name}.{form.name}.z{i}.{place}" for i in range(form.states)]
        answer, z = form.law(view, p, tuple(stage.read("state", row) for row in rows))
        if self._new:
            for row, x in zip(rows, z, strict=True):
                stage.write(self._new, row, x)
        return answer
