"""Intervals of fitted parameters that allow for model error and for residuals that are not white."""

from __future__ import annotations

import numpy as np

from .fit import Fit
from .hypothesis import residual
from .linear import jacobian
from .weighed import Weighed

NORMAL_95 = 1.96


def intervals(weighed: Weighed, found: Fit) -> np.ndarray:
    """(P, 2) 95 % intervals in scales.

    Gauss-Newton covariance with priors, times the residual's mean square and its correlation time: what the model does not
    explain counts as noise with the colour it has.
    """
    free = found.free
    sd = np.array([f.sd for f in free])
    derivatives = jacobian(weighed, free, found.x, found.run, found.sensors)
    n, precision = len(free), np.concatenate([sd**-2.0, weighed.sensor_precision])
    hessian = derivatives.T @ derivatives
    scale = 1.0 / np.sqrt(np.diag(hessian) + precision)
    inverse = np.linalg.pinv((hessian + np.diag(precision)) * scale[:, None] * scale, hermitian=True) * scale[:, None] * scale
    left = residual(weighed, found)[weighed.chosen.any(1)]
    inflation = max(1.0, float(np.nanmean(left**2))) * correlation_time(left)
    half = NORMAL_95 * np.sqrt(np.minimum(np.diag(inverse)[:n] * inflation, sd**2))
    return np.stack([found.x - half, found.x + half], 1)


def correlation_time(x: np.ndarray) -> float:
    """Readings per independent one, (n, channels): 1 + 2 sum of autocorrelations up to the first that is not positive."""
    x = np.nan_to_num(x - np.nanmean(x, axis=0))
    n = len(x)
    power = np.abs(np.fft.rfft(x, 2 * n, axis=0)) ** 2
    auto = np.fft.irfft(power.sum(1))[: n // 4]
    if auto[0] <= 0:
        return 1.0
    rho = auto / auto[0]
    ends = np.flatnonzero(rho <= 0)
    return float(1.0 + 2.0 * rho[1 : ends[0] if len(ends) else len(rho)].sum())
