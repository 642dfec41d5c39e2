"""Whether one hypothesis leaves less than another throughout: in block after block of the judged readings."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

#: t over blocks by which each effect beyond the first must leave less, a name than its special case, a form than one with fewer
#: parameters: what it adds may be luck in a few.
THROUGHOUT = 2.0


def better(worse: Iterable[float], best: Iterable[float]) -> float:
    """t of the mean of (worse - best) / (worse + best) over blocks: large where the second leaves less throughout, strong blocks or weak.

    That is half the log ratio where they differ little, and bounded, so that luck in one block does not decide.
    """
    d = np.tanh(0.5 * np.log(np.asarray(worse) / np.asarray(best)))
    spread = d.std(ddof=1) / np.sqrt(len(d))
    return float(d.mean() / spread) if spread > 0 else 0.0


def foreseen(squares: Iterable[float], counts: Iterable[float]) -> float:
    """t of `better` to be expected of a hypothesis that leaves squares (b,) beyond the noise, in its units, over so many readings (b,)."""
    left, n = np.asarray(squares, float), np.asarray(counts, float)
    d = left / (2.0 + left)
    chance = 8.0 * left / n / (2.0 + left) ** 3  # variance that noise gives each, to first order
    spread = np.sqrt((d.var(ddof=1) + chance.mean()) / len(d))
    return float(d.mean() / spread) if spread > 0 else 0.0
