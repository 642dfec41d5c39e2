"""Measure the paper's figures anew with the models that ship, and say what agrees and what does not.

Examples:
  hamr reproduce
  hamr reproduce residual --out out/figures
  hamr reproduce policies speed --json
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg


@dataclass(frozen=True, slots=True)
class Command:
    figures: Positional[Annotated[tuple[str, ...], arg(metavar="[FIGURE ...]")]] = ()
    """data, residual, policies, speed; all, in under two minutes, if none is given."""
    out: Path | None = None
    """Folder for the picture of residual."""

    def run(self) -> dict:
        from ..reproduce import reproduce

        return reproduce(self.figures, out=self.out)
