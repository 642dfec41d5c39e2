"""What may differ between lanes, as free numbers and as a whole: a re-tune, effects at places, a shift of clocks, zeros of sensors."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from hamr_description.names import AXES, JOINTS
from hamr_dynamics.bank_stages import USUAL
from hamr_dynamics.effects.bank import CHANGES
from hamr_dynamics.effects.effects_file import OF_THE_CHASSIS, Change, EffectsFile, PlacedEffect
from hamr_dynamics.effects.law import Form, Parameter
from hamr_dynamics.effects.library import find
from hamr_dynamics.effects.places import WORDS
from hamr_dynamics.effects.si import si_factor

from ..fitting.parameters import Free
from ..fitting.weighed import GAIN_SD

ZEROS = ("height", "roll", "pitch", *JOINTS)  # errors of the sensors' zeros: of the chassis's height mm and tilt rad, of the angles rad
ZERO_SD = (0.2, 0.02, 0.02, *(0.01 for _ in JOINTS))
SHIFT_SD = 0.25  # ms
#: By how much a model's numbers may be off, as shares of them, and a preload in usual forces: feet on the ground tell less than free legs.
CHANGE_SD = {"gain": 0.2, "stiffness": 0.2, "damping": 0.5, "inertia": 0.2, "preload": 1.0}
#: Kinds of forms whose sizes are in the scales of a leg; the others' are in inside units.
OF_JOINTS = ("drive", "force", "pair", "sense")


@dataclass(frozen=True)
class Setting:
    """One model of the robot and its sensors.

    Attributes:
        effects: effects and changes. shift: ms by which the drives act later than their stamps say. zeros: (11,) of ZEROS, inside units.
        gains: (8,) by which the angles' sensors read too much, as a share.
    """

    effects: EffectsFile = EffectsFile()
    shift: float = 0.0
    zeros: tuple[float, ...] = (0.0,) * len(ZEROS)
    gains: tuple[float, ...] = (0.0,) * len(JOINTS)


@dataclass(frozen=True, slots=True)
class Candidate:
    """An effect at a place, the same at all its joints.

    Attributes:
        effect, form: names. place: a word of `places.WORDS`; "chassis" for what acts on the chassis.
    """

    effect: str
    form: str
    place: str

    @property
    def law(self) -> Form:
        """Its form."""
        return find(self.effect, self.form)

    @property
    def name(self) -> tuple[str, str]:
        """Family and place, which is what counts as an answer."""
        return self.effect, self.place

    @property
    def places(self) -> tuple[int, ...]:
        """One: the joints of a place share their numbers."""
        return (0,)

    @property
    def joints(self) -> tuple[str, ...]:
        """Canonical names; none for the chassis."""
        return () if self.law.acts in OF_THE_CHASSIS else WORDS[self.place]

    def rows(self, *, shape: bool) -> list[tuple[str, Parameter]]:
        """(row, parameter) of its sizes or of its shapes."""
        return [(self.row(p), p) for p in (self.law.shapes if shape else self.law.sizes)]

    def row(self, parameter: Parameter) -> str:
        """Name of a free number."""
        return f"{self.effect}.{self.form}.{parameter.name}.{self.place}"

    def scale(self, parameter: Parameter) -> float:
        """Inside units of what `typical`, `low` and `high` of a parameter are in."""
        return USUAL.of(parameter.dimension) if self.law.acts in OF_JOINTS else 1.0


def retune(rest: dict[str, Sequence[float]]) -> list[Free]:
    """What a fair re-tune may change: the parameters of every joint, one shift of clocks, and the sensors.

    Args:
        rest: "stiffness", "damping" and "inertia" -> (swing, lift) that the model has at rest, inside units.
    """
    found = []
    for name in CHANGES:
        for joint in JOINTS:
            if name == "preload":
                found.append(Free(f"change.{name}.{joint}", USUAL.force, -np.inf, np.inf, 0.0, CHANGE_SD[name]))
            else:
                scale = 1.0 if name == "gain" else rest[name][AXES.index(joint.split("_")[1])]
                found.append(Free(f"change.{name}.{joint}", scale, -0.9, np.inf, 0.0, CHANGE_SD[name]))
    found.append(Free("shift", SHIFT_SD, -4.0, 4.0, 0.0, 1.0))
    found += [Free(f"gain.{joint}", GAIN_SD, -10.0, 10.0, 0.0, 1.0) for joint in JOINTS]
    return [*found, *(Free(f"zero.{name}", sd, -np.inf, np.inf, 0.0, 1.0) for name, sd in zip(ZEROS, ZERO_SD, strict=True))]


def effect_parameters(candidates: Iterable[Candidate]) -> list[Free]:
    """Sizes and shapes of effects: sizes with a wide prior about zero, shapes one about their typical value."""
    found = []
    for c in candidates:
        for shape in (False, True):
            for row, p in c.rows(shape=shape):
                center, sd = (p.typical, max(2.0 * p.typical, 0.3 * min(p.high - p.low, 10.0))) if shape else (0.0, 30.0 * p.typical)
                found.append(Free(row, c.scale(p), p.low, p.high, center, sd))
    return found


def setting(free: Sequence[Free], x: np.ndarray, effects: Sequence[Candidate] = ()) -> Setting:
    """Free numbers (P,) in scales as one model; effects without a free number of theirs are at their typical shapes, and off."""
    values = {f.row: f.scale * float(v) for f, v in zip(free, x, strict=True)}
    placed = []
    for c in effects:
        own = {p.name: values.get(c.row(p), c.scale(p) * p.typical if p.shape else 0.0) * si_factor(p.dimension) for p in c.law.parameters}
        placed.append(PlacedEffect(c.effect, c.form, c.joints, own))
    changes = []
    for row, v in values.items():
        if row.startswith("change.") and v:
            _, name, joint = row.split(".")
            changes.append(Change(name, (joint,), v * si_factor(CHANGES[name])))
    zeros = tuple(values.get(f"zero.{name}", 0.0) for name in ZEROS)
    gains = tuple(values.get(f"gain.{joint}", 0.0) for joint in JOINTS)
    return Setting(EffectsFile(tuple(placed), tuple(changes)), values.get("shift", 0.0), zeros, gains)
