"""Fits in long pieces from where shorter ones lead: what swings on for a minute fits from afar only by chance."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .fit import Fit, fit
from .model import START
from .parameters import Free
from .weighed import Weighed


def continued(weighed: Weighed, free: Sequence[Free], x: np.ndarray) -> Fit:
    """A fit from where it ends in pieces of half the length, there likewise, down to those in which the re-tune was found.

    A phase that is off by a few turns at the end of a long piece says nothing of which way is better; in a short one it is off by little
    (continuation in the length, as of multiple shooting).

    Args:
        free, x: as of `fit`; numbers that move the starts of pieces begin where these were measured.

    Raises:
        BagError: the model diverges.
    """
    if weighed.shorter is None:
        return fit(weighed, free, x)
    before = continued(weighed.shorter, *weighed.shorter.model.with_starts(free, x))
    there = {f.row: value for f, value in zip(before.free, before.x, strict=True) if not f.row.startswith(START)}
    return fit(weighed, free, np.array([there.get(f.row, 0.0) for f in free]))
