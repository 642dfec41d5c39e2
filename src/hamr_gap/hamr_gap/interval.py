"""Intervals of fitted parameters that allow for model error and for residuals that are not white."""

from __future__ import annotations

import numpy as np

from .colour import correlation_time
from .fit import Fit
from .hypothesis import residual
from .linear import jacobian
from .weighed import Weighed

NORMAL_95 = 1.96


def intervals(weighed: Weighed, found: Fit) -> np.ndarray:
    """(P, 2) 95 % intervals in scales.

    Gauss-Newton covariance, the residual's mean square and its correlation time counting as noise: what the model does not explain is
    noise with the colour it has.
    """
    free = found.free
    sd = np.array([f.sd for f in free])
    derivatives = jacobian(weighed, free, found.x, found.run, found.sensors)
    left = residual(weighed, found)[weighed.chosen.any(1)]
    inflation = max(1.0, float(np.nanmean(left**2))) * correlation_time(left)
    n, precision = len(free), inflation * np.concatenate([sd**-2.0, weighed.sensor_precision])
    hessian = derivatives.T @ derivatives
    scale = 1.0 / np.sqrt(np.diag(hessian) + precision)
    inverse = np.linalg.pinv((hessian + np.diag(precision)) * scale[:, None] * scale, hermitian=True) * scale[:, None] * scale
    half = NORMAL_95 * np.sqrt(inflation * np.diag(inverse)[:n])
    return np.stack([found.x - half, found.x + half], 1)
