"""The bank: every form of the library at every place of one leg (or of a machine of one joint), its rows, and how it acts in a trace.

`machine` and the stages of the whole robot build on it, so that one implementation serves both.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..emit import Stage
from ..vec import add
from .law import Form, Input, Joint, Motion, Pair, PairPush, Push, Scales, Signal
from .library import library

#: What a fair re-tune may change at each joint: relative drive gain; added stiffness F/Q, damping F T/Q, inertia F T^2/Q; preload F.
CHANGES = {"gain": "1", "stiffness": "F/Q", "damping": "F*T/Q", "inertia": "F*T^2/Q", "preload": "F"}
#: Kinds of forms that act inside a step, in the order in which they act.
ACTS = ("drive", "force", "pair", "sense")


@dataclass(frozen=True, slots=True)
class Bank:
    """All forms of some kinds at one machine: of one joint, of two coupled ones, or of none (the chassis)."""

    joints: int
    acts: tuple[str, ...] = ACTS

    @property
    def forms(self) -> list[tuple[str, Form]]:
        """(effect name, form) in order of action."""
        acts = [kind for kind in self.acts if kind != "pair" or self.joints == 2]
        found = [(name, form) for name, effect in library().items() for form in effect.forms if form.acts in acts]
        return sorted(found, key=lambda item: item[1].order)

    def of(self, *acts: str) -> list[tuple[str, Form]]:
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
        return tuple(
            f"{name}.{form.name}.z{i}.{place}" for name, form in self.of(*acts) for place in self.places(form) for i in range(form.states)
        )

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

    def add(self, j: int, push: Push) -> None:
        """A push at joint j."""
        diagonal = (0, 2)[j] if len(self.force) == 2 else 0
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

    def change(self, name: str) -> tuple:
        """(n,) of a re-tuned parameter."""
        return tuple(self._stage.read("param", f"change.{name}.{j}") for j in self._joints)

    def drive(self, u: tuple, time, step) -> tuple:
        """(n,) drive that acts, of the commanded one."""
        u = tuple(x + g * x for x, g in zip(u, self.change("gain"), strict=True))
        for act in self._laws("drive"):
            u = tuple(act(j, Input(u[j], u, j, time, step)) for j in self._joints)
        return u

    def push(self, equations: Equations, q: tuple, v: tuple, drive: tuple, stiffness: tuple, inertia: tuple, time, step) -> None:
        """Adds changes and effects to the equations; stiffness and inertia (n,) are the machine's own at rest, without changes."""
        change = {name: self.change(name) for name in CHANGES}
        stiff = tuple(x + y for x, y in zip(stiffness, change["stiffness"], strict=True))
        heavy = tuple(x + y for x, y in zip(inertia, change["inertia"], strict=True))
        for j in self._joints:
            k, d = change["stiffness"][j], change["damping"][j]
            equations.add(j, Push(change["preload"][j] - k * q[j] - d * v[j], k, d, change["inertia"][j]))
        for act in self._laws("force"):
            for j in self._joints:
                equations.add(j, act(j, Joint(q[j], v[j], drive[j], stiff[j], heavy[j], time, step)))
        for act in self._laws("pair"):
            equations.add_pair(act(0, Pair(q, v, drive, stiff, heavy, step)))

    def leg(self, leg):
        """A `leg.Leg` as forms that act on it leave it."""
        for act in self._laws("leg"):
            leg = act(0, leg)
        return leg

    def tow(self, motion: Motion) -> tuple:
        """(3,) force on the chassis."""
        total = (0.0, 0.0, 0.0)
        for act in self._laws("tow"):
            total = add(total, act(0, motion))
        return total

    def sense(self, reading: tuple, step) -> tuple:
        """(n,) what the joints' sensors say."""
        for act in self._laws("sense"):
            reading = tuple(act(j, Signal(reading[j], step)) for j in self._joints)
        return reading

    def _laws(self, acts: str) -> list[Callable]:
        """Functions (place, view) -> answer; they read their parameters and states and write the states back."""
        stage, new, param = self._stage, self._new, self._param

        def acting(name: str, form: Form) -> Callable:
            def act(place: int, view):
                p = {x.name: stage.read(param, f"{name}.{form.name}.{x.name}.{place}") for x in form.parameters}
                rows = [f"{name}.{form.name}.z{i}.{place}" for i in range(form.states)]
                answer, z = form.law(view, p, tuple(stage.read("state", row) for row in rows))
                if new:
                    for row, x in zip(rows, z, strict=True):
                        stage.write(new, row, x)
                return answer

            return act

        return [acting(name, form) for name, form in self._bank.of(acts)]
