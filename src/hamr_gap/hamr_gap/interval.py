"""Intervals of fitted parameters that allow for model error and for residuals that are not white."""

from __future__ import annotations

import numpy as np

from .fit import DELTA, Fit, Weighed
from .hypothesis import residual

NORMAL_95 = 1.96


def intervals(weighed: Weighed, found: Fit) -> np.ndarray:
    """(P, 2) 95 % intervals in scales.

    Gauss-Newton covariance with priors, times the residual's mean square and its correlation time: what the model does not
    explain counts as noise with the colour it has.
    """
    model, until, free = weighed.model, weighed.until, found.free
    sd = np.array([f.sd for f in free])
    delta = DELTA * np.minimum(sd, 1.0)
    delta = np.where(found.x + delta > np.array([f.high for f in free]), -delta, delta)
    probes = model.runs(free, found.x + np.diag(delta), until)
    base = weighed.vector(found.reading)
    read = [weighed.vector(found.sensors.read(p, model.reading_step, model.starts)) for p in probes]
    columns = [(y - base) / d for y, d in zip(read, delta, strict=True)]
    jacobian = np.column_stack([*columns, weighed.sensor_columns(found.run)])
    n, precision = len(free), np.concatenate([sd**-2.0, weighed.sensor_precision])
    hessian = jacobian.T @ jacobian
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
