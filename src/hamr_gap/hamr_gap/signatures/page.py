"""An effect's page, and the index of all, in Markdown: everything from the library, nothing besides."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from inspect import getdoc
from itertools import groupby

import yaml

from hamr_dynamics.effects.effects_file import OF_LEGS, OF_THE_CHASSIS, EffectsFile
from hamr_dynamics.effects.law import Effect, Form, Parameter
from hamr_dynamics.effects.library import library
from hamr_dynamics.effects.si import si_unit

from ..walking.setting import OF_JOINTS
from .figure import Panel
from .shown import example, typical, unit_of
from .walk import GAIT, STAND_S

PARTS = {
    "actuator": "between the voltage that is commanded and the one that acts",
    "transmission": "in the forces at a joint",
    "body": "in what moves, and in the forces on it",
    "contact": "between a foot and the ground",
    "sensor": "between a joint's angle and its reading",
}
NEEDS = {
    "ground": "a run on the ground; a suspended robot does not show it",
    "deflections": "sensors at the actuators' tips besides those at the joints",
    "closed loop": "a run in closed loop",
    "hold": "drives that hold for long",
    "unnamed": "nothing: it is no name, and stands for one that is not known",
}
ALIKE = 3  # parameters that differ in name only, of which all are listed
ON_LEG = "Simulated: the suspended front-left leg of HAMR-simple, voltages about neutral on its swing joint, its lift joint held still."
ON_LEG_BOTH = "Simulated: the suspended front-left leg of HAMR-simple, voltages about neutral on its swing joint, its lift joint free."
ON_GROUND = (
    f"Simulated: HAMR-simple on the ground, standing for {STAND_S:g} s, then in an open-loop trot of {GAIT['frequency_hz']:g} Hz and "
    f"{GAIT['amplitude']:g} V, which walks backwards."
)


def page(effect: Effect, panels: Sequence[Panel]) -> str:
    """The page of an effect whose picture has these panels."""
    blocks = [
        f"# `{effect.name}`",
        effect.summary,
        f"![{effect.name}: {'; '.join(_line(p.title) for p in panels)}]({effect.name}.svg)",
        f"{_simulated(effect, panels)} Grey without the effect, blue with it, as in the file below.",
        "\n".join(f"- **{_line(p.title)}**: {p.shows}." for p in panels),
        "## What to know",
        "\n".join(f"- **{name}**: {words}." for name, words in _facts(effect)),
        "## Forms",
        *(block for form in effect.forms for block in _form(form)),
        "*Sizes* are zero where the effect is off, *shapes* are not. Typical values and the bounds within which `hamr gap` searches are "
        + ("those of a leg of HAMR-simple that is shaken by noise." if effect.forms[0].acts in OF_JOINTS else "those of the robot."),
        "## In an effects file",
        f"```yaml\n{snippet(effect)}```",
        "All of the file: [effects](../effects.md). All effects: [library](README.md). "
        f"Written by `python -m hamr_gap.signatures {effect.name}`.",
    ]
    return "\n\n".join(blocks) + "\n"


def index() -> str:
    """The table of all pages."""
    rows = [f"| [`{e.name}`]({e.name}.md) | {e.part} | {e.summary} |" for e in library().values()]
    head = ["# The library of effects", "", "What each effect does, in pictures. How to switch them on: [effects](../effects.md)."]
    head += ["Written by `python -m hamr_gap.signatures`.", "", "| effect | part | what it is |", "|---|---|---|"]
    return "\n".join([*head, *rows, ""])


def snippet(effect: Effect) -> str:
    """The effects file of what is shown."""
    return yaml.safe_dump(EffectsFile((example(effect),)).as_dict(), sort_keys=False, default_flow_style=None, width=110)


def _simulated(effect: Effect, panels: Sequence[Panel]) -> str:
    if effect.forms[0].acts not in OF_JOINTS:
        return ON_GROUND
    return ON_LEG_BOTH if any("lift" in p.y for p in panels) else ON_LEG


def _facts(effect: Effect) -> Iterable[tuple[str, str]]:
    yield "acts", f"{PARTS[effect.part]} ({effect.part})"
    if effect.contains:
        yield "contains, as a special case", _links(effect.contains)
    if effect.mimics:
        yield "can be taken for, beside a re-tune", _links(effect.mimics)
    if inside := [other.name for other in library().values() if effect.name in other.contains]:
        yield "is a special case of", _links(inside)
    for other, condition in effect.same_as.items():
        yield f"cannot be told from {_links([other])}", condition
    if effect.needs:
        yield "to be seen it needs", "; ".join(NEEDS[need] for need in effect.needs)
    yield "shows best", effect.experiment
    yield "source", effect.source


def _links(names: Iterable[str]) -> str:
    return ", ".join(f"[`{name}`]({name}.md)" if name in library() else name for name in names)


def _form(form: Form) -> Iterable[str]:
    yield f"### `{form.name}`"
    yield f"{_line(getdoc(form.law))} Placed at {_place(form)}."
    rows = ["| parameter | unit | meaning | | typical | from | to |", "|---|---|---|---|---|---|---|"]
    for _, group in groupby(form.parameters, lambda p: (p.dimension, p.shape, p.typical, p.low, p.high)):
        alike = list(group)
        if len(alike) <= ALIKE:
            rows += [_row(form, p) for p in alike]
        else:
            rows += [_row(form, alike[0]), f"| ... | | {len(alike)} alike | | | | |", _row(form, alike[-1])]
    yield "\n".join(rows)


def _row(form: Form, p: Parameter) -> str:
    numbers = [typical(form, p), *(bound * unit_of(form, p) for bound in (p.low, p.high))]
    kind = "shape" if p.shape else "size"
    return f"| `{p.name}` | {si_unit(p.dimension)} | {p.doc} | {kind} | {' | '.join(f'{x:.2g}' for x in numbers)} |"


def _place(form: Form) -> str:
    return "the chassis" if form.acts in OF_THE_CHASSIS else "a leg" if form.acts in OF_LEGS else "a joint"


def _line(text: str) -> str:
    return " ".join(text.split())
