"""What a model leaves of segments: mean squares in units of the noise, without the few whose contact may have gone another way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..naming.hypothesis import Hypothesis
from .replay import Replay
from .segments import CHANGES
from .starts import Started

BLOCK_MS = 100.0  # of judged segments, that count as one
WORST = 0.1  # of the judged segments, that do not count: their contact may have gone another way


@dataclass(frozen=True, eq=False)
class Judged(Hypothesis):
    """A hypothesis on the ground.

    Attributes:
        parts: (7,) mean squares of the angles' residual, and of each axis of the chassis (position, turn). A payload shows in few readings
            of many: of 190 in 20 ms five tell the pitch.
    """

    parts: np.ndarray


def exceeds(worse: Judged, better: Judged, least: float) -> bool:
    """Whether one leaves more than another by what counts as a gap, in all readings or in a part of them."""
    return bool(max(worse.left - better.left, *(worse.parts - better.parts)) > least)


def trimmed(residual: np.ndarray) -> tuple[float, np.ndarray]:
    """Mean square of (s, c) without the worst segments, and (s,) of each segment."""
    each = np.mean(residual**2, 1)
    return float(np.mean(each[_usual(each)])), each


def left_of(replay: Replay, begun: Started) -> tuple[float, np.ndarray, np.ndarray]:
    """Mean square that started segments leave, (b,) of blocks, and (7,) of parts."""
    residual = begun.residual[:, :-CHANGES]
    left, each = trimmed(residual)
    block = (replay.segments.first * replay.segments.walk.step // BLOCK_MS).astype(int)
    return left, np.array([each[block == b].mean() for b in np.unique(block)]), replay.observed.parts(residual**2, _usual(each))


def floors(replay: Replay, slopes: np.ndarray) -> np.ndarray:
    """(7,) mean squares that noise leaves of parts: the starts take up the rest.

    Args:
        slopes: (s, readings + 28, 28) derivatives by the starts.
    """
    basis = np.linalg.qr(slopes).Q[:, :-CHANGES]
    return replay.observed.parts(1.0 - np.sum(basis**2, 2))


def _usual(each: np.ndarray) -> np.ndarray:
    """Indices of all but the largest."""
    return np.argsort(each)[: max(1, round((1.0 - WORST) * len(each)))]
