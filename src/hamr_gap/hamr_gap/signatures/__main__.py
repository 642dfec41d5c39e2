"""Pages of effects, or of all: python -m hamr_gap.signatures [--out docs/effects] [NAME ...]."""

from __future__ import annotations

import sys
from pathlib import Path

import tyro

from hamr_description.errors import HamrError
from hamr_dynamics.effects.library import find, library

from .figure import svg
from .page import index, page
from .shown import panels


def write(name: str, out: Path) -> None:
    """NAME.md and NAME.svg into a folder; ConfigError if there is no such effect."""
    find(name)
    effect = library()[name]
    shown = panels(effect)
    (out / f"{name}.md").write_text(page(effect, shown))
    (out / f"{name}.svg").write_text(svg(shown))


def main(names: tyro.conf.Positional[tuple[str, ...]] = (), /, out: Path = Path("docs/effects")) -> None:
    """Writes the pages of effects with their pictures, and the index of all.

    Args:
        names: effects; all of the library if none is named.
        out: folder.
    """
    out.mkdir(parents=True, exist_ok=True)
    for name in names or library():
        write(name, out)
    (out / "README.md").write_text(index())


if __name__ == "__main__":
    try:
        tyro.cli(main, prog="python -m hamr_gap.signatures")
    except HamrError as error:
        sys.exit(str(error))
