"""Drives between their samples."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import maximum_filter

JUMP = 3.0  # a step of the drive this many times the usual one and its neighbours is a jump
NEAR = 5  # samples in which it has neighbours


def resampled(u: np.ndarray, substeps: int, *, within: float) -> np.ndarray:
    """(n * substeps,) of samples (n,): cubic splines between their jumps, each piece held from its last sample to the jump.

    Args:
        within: where in its step each value is taken, 0 its beginning, less than that before.
    """
    step = np.abs(np.diff(u))
    # a signal that is only fast has large steps near by too
    beside = maximum_filter(step, footprint=np.arange(-NEAR, NEAR + 1) != 0, mode="constant")
    jumps = np.flatnonzero((step > JUMP * np.sqrt(np.mean(step**2))) & (step > JUMP * beside)) + 1
    fine = np.empty(len(u) * substeps)
    for start, stop in zip([0, *jumps], [*jumps, len(u)], strict=True):
        at = np.clip((np.arange((stop - start) * substeps) + within) / substeps, 0.0, stop - start - 1)
        piece = u[start:stop]
        fine[start * substeps : stop * substeps] = CubicSpline(np.arange(len(piece)), piece)(at) if len(piece) > 1 else piece[0]
    return fine
