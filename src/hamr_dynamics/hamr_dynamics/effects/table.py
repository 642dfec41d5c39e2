"""The library as a Markdown table, for docs/effects.md: python -m hamr_dynamics.effects.table."""

from __future__ import annotations

import sys

from .law import Effect, Form
from .library import library
from .si import si_unit

_LONG = 6  # parameters that a form may have before only the first and the last are named


def table() -> str:
    """One row an effect: name and what it is, part, forms with their parameters in SI, what shows it best, source."""
    lines = ["| effect | part | forms: parameters | shows best | source |", "|---|---|---|---|---|"]
    return "\n".join([*lines, *(_row(effect) for effect in library().values()), ""])


def _row(effect: Effect) -> str:
    forms = "<br>".join(_form(form) for form in effect.forms)
    needs = f" (needs: {', '.join(effect.needs)})" if effect.needs else ""
    return f"| `{effect.name}`: {effect.summary} | {effect.part} | {forms} | {effect.experiment}{needs} | {effect.source} |"


def _form(form: Form) -> str:
    named = [f"{p.name} [{si_unit(p.dimension)}]" for p in form.parameters]
    if len(named) > _LONG:
        named = [named[0], f"... {len(named)} in all ...", named[-1]]
    return f"`{form.name}`: {', '.join(named)}"


if __name__ == "__main__":
    sys.stdout.write(table())
