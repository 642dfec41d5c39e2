"""Residuals are not white: how many of their readings say as much as one independent reading."""

from __future__ import annotations

import numpy as np


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
