"""Hypotheses about what is missing, and what each leaves on segments not fitted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .fit import Fit
from .segments import CHANGES
from .setting import Candidate
from .starts import Replay, Started

BLOCK_MS = 100.0  # of judged segments, that count as one
WORST = 0.1  # of the judged segments, that do not count: their contact may have gone another way


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """Some effects (none: a re-tune alone), fitted.

    Attributes:
        effects. fit. left: mean square of judged readings in units of noise, without the worst segments. blocks: (b,) the same of blocks.
    """

    effects: tuple[Candidate, ...]
    fit: Fit
    left: float
    blocks: np.ndarray

    @property
    def names(self) -> frozenset:
        """Families and places."""
        return frozenset(c.name for c in self.effects)

    @property
    def parameters(self) -> int:
        """Number of sizes and shapes."""
        return sum(len(c.law.parameters) for c in self.effects)


def trimmed(residual: np.ndarray) -> tuple[float, np.ndarray]:
    """Mean square of (s, c) without the worst segments, and (s,) of each segment."""
    each = np.mean(residual**2, 1)
    return float(np.mean(np.sort(each)[: max(1, round((1.0 - WORST) * len(each)))])), each


def left_of(replay: Replay, begun: Started) -> tuple[float, np.ndarray]:
    """Mean square that started segments leave, and (b,) of blocks."""
    left, each = trimmed(begun.residual[:, :-CHANGES])
    block = (replay.segments.first * replay.segments.walk.step // BLOCK_MS).astype(int)
    return left, np.array([each[block == b].mean() for b in np.unique(block)])
