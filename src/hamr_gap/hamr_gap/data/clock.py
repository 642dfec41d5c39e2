"""Times of rows: even ones, where they jump, and what rows at uneven times would have read at even ones."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline

from hamr_description.errors import BagError

from .record import SAME
from .resample import between

EVEN = 0.02  # of a step: a clock's noise
MOST = 0.125  # of a step, rms: more is no clock at all
OTHER = 0.1  # of a step: two tables that differ by more were sampled at different rates
GAP = 0.5  # of a step more or less than one: the record breaks there


@dataclass(frozen=True)
class Clock:
    """When the rows of a table were taken.

    Attributes:
        time: (n,) T. step: T between rows. breaks: rows at which a new stretch begins. uneven: of a step, the most that any is longer or
            shorter than one; zero where that is a clock's noise.
    """

    time: np.ndarray
    step: float
    breaks: tuple[int, ...]
    uneven: float

    @classmethod
    def of(cls, time: np.ndarray, where: str, step: float | None = None) -> Clock:
        """Of (n,) T in a table.

        Args:
            step: T between even times, where these are uneven or nearly that far apart; what is usual between them if not given.

        Raises:
            BagError: a time is missing, they do not rise, or are so uneven that nobody knows the step; one sentence.
        """
        if len(time) < 3 or not np.isfinite(time).all():
            raise BagError(f"{where} needs a time in each of at least three rows.")
        usual = float(np.median(np.diff(time)))
        if not usual > 0:
            raise BagError(f"The times in {where} do not rise; sort the rows.")
        off = np.abs(np.diff(time) / usual - 1.0)
        breaks = tuple(int(i) for i in np.flatnonzero(off > GAP) + 1)
        inside = off[off <= GAP] if (off <= GAP).any() else off
        if np.sqrt(np.mean(inside**2)) > MOST:
            raise BagError(f"The times in {where} are uneven by {100 * inside.max():.0f} % of a step; resample them to even ones.")
        lengths = [(time[b - 1] - time[a], b - 1 - a) for a, b in pairwise((0, *breaks, len(time)))]
        own = float(sum(t for t, _ in lengths) / max(1, sum(n for _, n in lengths)))
        apart = abs(own / step - 1.0) if step else 0.0
        if inside.max() <= EVEN and (apart <= SAME or apart > OTHER):
            return cls(time, own, breaks, 0.0)
        return cls(time, step or own, breaks, max(float(inside.max()), apart))

    def evened(self, drives: np.ndarray, readings: np.ndarray) -> tuple[np.ndarray, np.ndarray, tuple[int, ...]]:
        """(m, joints) and (m, channels) of (n, joints) and (n, channels) at even times from the first row of each stretch on, and its
        breaks: splines through the readings, and through the drives between their jumps."""
        if not self.uneven:
            return drives, readings, self.breaks
        parts = []
        for a, b in pairwise((0, *self.breaks, len(self.time))):
            own = self.time[a:b]
            even = own[0] + self.step * np.arange(int((own[-1] - own[0]) / self.step + EVEN) + 1)
            parts.append((np.stack([between(own, u, even) for u in drives[a:b].T], 1), _read(own, readings[a:b], even)))
        breaks = np.cumsum([len(u) for u, _ in parts])[:-1]
        return *(np.concatenate(part) for part in zip(*parts, strict=True)), tuple(int(b) for b in breaks)


def _read(time: np.ndarray, x: np.ndarray, even: np.ndarray) -> np.ndarray:
    """(m, k) of (n, k) at other times; NaN between rows of which either is."""
    if len(time) == 1:
        return x
    found = np.full((len(even), x.shape[1]), np.nan)
    after = np.clip(np.searchsorted(time, even), 1, len(time) - 1)
    for c, column in enumerate(x.T):
        known = np.isfinite(column)
        said = known[after - 1] & known[after]
        if said.any():
            found[said, c] = CubicSpline(time[known], column[known])(even[said])
    return found
