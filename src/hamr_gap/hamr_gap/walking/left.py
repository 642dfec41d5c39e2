"""What a model leaves of segments: mean squares in units of the noise, without the few whose contact may have gone another way."""

from __future__ import annotations

import numpy as np

from .replay import Replay
from .segments import CHANGES
from .starts import Started

BLOCK_MS = 100.0  # of judged segments, that count as one
WORST = 0.1  # of the judged segments, that do not count: their contact may have gone another way


def trimmed(residual: np.ndarray) -> tuple[float, np.ndarray]:
    """Mean square of (s, c) without the worst segments, and (s,) of each segment."""
    each = np.mean(residual**2, 1)
    return float(np.mean(np.sort(each)[: max(1, round((1.0 - WORST) * len(each)))])), each


def left_of(replay: Replay, begun: Started) -> tuple[float, np.ndarray]:
    """Mean square that started segments leave, and (b,) of blocks."""
    left, each = trimmed(begun.residual[:, :-CHANGES])
    block = (replay.segments.first * replay.segments.walk.step // BLOCK_MS).astype(int)
    return left, np.array([each[block == b].mean() for b in np.unique(block)])
