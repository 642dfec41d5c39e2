"""Drives between their samples."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import maximum_filter

JUMP = 3.0  # a step of the drive this many times the usual one and its neighbours is a jump
NEAR = 5  # samples in which it has neighbours


def resampled(u: np.ndarray, substeps: int, *, within: float) -> np.ndarray:
    """(n * substeps,) of samples (n,), as `between`.

    Args:
        within: where in its step each value is taken, 0 its beginning, less than that before.
    """
    return between(np.arange(len(u)), u, np.arange(len(u) * substeps) / substeps, late=-within / substeps)


def between(time: np.ndarray, u: np.ndarray, at: np.ndarray, *, late: float = 0.0) -> np.ndarray:
    """(m,) at times of samples (n,) at others: cubic splines between their jumps, each piece held from its last sample to the jump.

    Args:
        time: (n,) of the samples. at: (m,), both rising. late: by how much, within a piece.
    """
    if len(u) == 1:
        return np.full(len(at), u[0])
    step = np.abs(np.diff(u))
    # a signal that is only fast has large steps near by too
    beside = maximum_filter(step, footprint=np.arange(-NEAR, NEAR + 1) != 0, mode="constant")
    jumps = np.flatnonzero((step > JUMP * np.sqrt(np.mean(step**2))) & (step > JUMP * beside)) + 1
    found, edges = np.empty(len(at)), [0, *np.searchsorted(at, time[jumps]), len(at)]
    for start, stop, a, b in zip([0, *jumps], [*jumps, len(u)], edges[:-1], edges[1:], strict=True):
        own, piece = time[start:stop] - time[start], u[start:stop]
        found[a:b] = CubicSpline(own, piece)(np.clip(at[a:b] - time[start] - late, 0.0, own[-1])) if len(piece) > 1 else piece[0]
    return found
