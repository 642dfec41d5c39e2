"""Everything that a walk may be said to miss: forms of effects, the places each can have, and the shapes at which they are tried."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

from hamr_description.names import AXES, JOINTS, LEGS
from hamr_dynamics.effects.effects_file import OF_LEGS, OF_THE_CHASSIS
from hamr_dynamics.effects.law import Form
from hamr_dynamics.effects.library import library
from hamr_dynamics.effects.places import WORDS

from .setting import Candidate

PLACES = {"joint": ("all", *AXES, *LEGS, *JOINTS), "leg": ("all", *LEGS), "chassis": ("chassis",)}
UNITS = {"joint": JOINTS, "leg": LEGS, "chassis": ("chassis",)}  # that places are made of
OPTIONS = 3  # sets of shapes that are tried of what acts at every joint or leg
#: Forms that remember for longer than a segment and what leads up to it.
SLOW = ("piezo_creep",)
Shapes = tuple[tuple[str, float], ...]  # (parameter, value in scales)


def kind(form: Form) -> str:
    """Of which of PLACES a form is."""
    return "chassis" if form.acts in OF_THE_CHASSIS else "leg" if form.acts in OF_LEGS else "joint"


def missing(effect: str) -> str:
    """Why segments of a walk cannot show an effect; empty if they can."""
    needs = library()[effect].needs
    if effect in SLOW:
        return "it remembers for longer than a segment lasts"
    if "deflections" in needs:
        return "segments do not use sensors on the actuator's side; hang the robot up"
    if "quantised" in needs:
        return "it is seen in the readings themselves"
    return "it is no name" if "unnamed" in needs else ""


def forms() -> list[tuple[str, Form]]:
    """(effect, form) of all that may be named."""
    return [(name, form) for name, effect in library().items() if not missing(name) for form in effect.forms]


def units(c: Candidate) -> tuple[str, ...]:
    """The units that its place is made of."""
    if kind(c.law) == "joint":
        return c.joints
    return tuple(leg for leg in LEGS if f"{leg}_{AXES[0]}" in WORDS[c.place]) if kind(c.law) == "leg" else ("chassis",)


def shapes_of(form: Form) -> Sequence[Shapes]:
    """Sets of shapes at which a form is tried."""
    options = [[(p.name, v) for v in (p.screen or (p.typical,))] for p in form.shapes]
    return list(product(*options))[: None if kind(form) == "chassis" else OPTIONS]
