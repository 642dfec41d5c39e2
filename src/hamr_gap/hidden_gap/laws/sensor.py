"""Laws of the angle sensor, on samples at 20 kHz; the tip sensors stay as they are."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numba import njit
from scipy.signal import lfilter

from hamr_description.rates import SERVO_MS

from .law import ANY, LAWS, law


def sensed(name: str, angle: np.ndarray, parameters: Mapping[str, float]) -> np.ndarray:
    """An angle (n,) rad as the sensor with this law tells it."""
    return LAWS[name].function(angle, **parameters)


@law("sensor_latency", size="tau", places=ANY, sensor=True, tau=(0.02, 8.0))
def pipeline(angle, tau):
    """Every sample is tau ms old."""
    t = np.arange(angle.size) * SERVO_MS
    return np.interp(t - tau, t, angle)


@law("sensor_lag", size="tau", places=ANY, sensor=True, tau=(0.02, 10.0))
def low_pass(angle, tau):
    """First order, exact for an angle that is linear between samples."""
    keep = np.exp(-SERVO_MS / tau)
    mean = (1.0 - keep) * tau / SERVO_MS
    out, _ = lfilter([1.0 - mean, mean - keep], [1.0, -keep], angle, zi=[mean * angle[0]])
    return out


@law("sensor_lag", size="tau", places=ANY, sensor=True, tau=(0.05, 8.0))
def moving_mean(angle, tau):
    """The mean over the last 2 tau ms: a boxcar."""
    width = max(2.0 * tau / SERVO_MS, 1.0)
    total = np.concatenate([[0.0], np.cumsum(angle)])
    at = np.arange(1, angle.size + 1)
    start = at - width
    return (total[at] - np.where(start > 0, np.interp(start, np.arange(total.size), total), start * angle[0])) / width


@law("sensor_quantisation", size="line", places=ANY, sensor=True, line=(1e-4, 0.3), phase=(0.0, 1.0))
def mid_tread(angle, line, phase):
    """Nearest line of a scale with lines `line` rad apart."""
    return line * (np.round(angle / line - phase) + phase)


@law("sensor_quantisation", size="line", places=ANY, sensor=True, line=(1e-4, 0.25), stick=(0.1, 0.45), phase=(0.0, 1.0))
def counter(angle, line, stick, phase):
    """A counter with hysteresis: it moves on when the angle is more than half a line plus `stick` lines away."""
    return line * (_count(angle / line - phase, 0.5 + stick) + phase)


@law("sensor_nonlinearity", size="error", places=ANY, sensor=True, error=(5e-4, 0.3), lines=(5.0, 25.0), phase=(-3.1, 3.1))
def eccentric(angle, error, lines, phase):
    """An eccentric code disc."""
    return angle + error * (np.sin(lines * angle + phase) - np.sin(phase))


@law("sensor_nonlinearity", size="bend", places=ANY, sensor=True, bend=(0.1, 6.0), centre=(-0.2, 0.2))
def arctan_scale(angle, bend, centre):
    """A scale that shortens away from its centre."""
    return (np.arctan(bend * (angle - centre)) + np.arctan(bend * centre)) / bend


@njit(cache=True)
def _count(x, edge):
    out, now = np.empty_like(x), np.round(x[0])
    for k in range(x.size):
        if abs(x[k] - now) > edge:
            now = np.round(x[k])
        out[k] = now
    return out
