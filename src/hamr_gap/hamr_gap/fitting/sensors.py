"""What sensors make of a run: scales, biases, and clocks that are late."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit

LITTLE = 0.001  # of a reading's step, that first order serves as well
TAPS = range(-3, 4)  # readings that a late one is interpolated from


@dataclass(frozen=True)
class Sensors:
    """reading = (1 + gain) y(t - shift) + bias.

    Attributes:
        bias, gain: (channels,). shift: T.
    """

    bias: np.ndarray
    gain: np.ndarray
    shift: float

    @classmethod
    def none(cls, channels: int) -> Sensors:
        """Sensors that change nothing."""
        return cls(np.zeros(channels), np.zeros(channels), 0.0)

    def read(self, y: np.ndarray, step: float, starts: Sequence[int] = ()) -> np.ndarray:
        """(..., n, channels) readings of a run; from `starts` it starts as measured, so that there no shift moves it."""
        read = late(y, self.shift, step, starts)
        flat = read.reshape(*y.shape[:-2], -1)  # so that inner loops are long
        return (np.tile(1.0 + self.gain, y.shape[-2]) * flat + np.tile(self.bias, y.shape[-2])).reshape(y.shape)


@np.errstate(over="ignore", invalid="ignore")  # a trial run that diverges has an infinite cost, which is all that is asked of it
def late(y: np.ndarray, shift: float, step: float, starts: Sequence[int] = ()) -> np.ndarray:
    """(..., n, channels) of a run, `shift` later: by polynomials of degree six through its readings, in short pieces to first order."""
    if starts or abs(shift) < LITTLE * step:
        return y - shift * slope(y, step, starts) if shift else y
    whole = round(shift / step)
    part = shift / step - whole
    reach = TAPS[-1] + abs(whole)
    wide = np.concatenate([beyond(y, reach), y, beyond(y[..., ::-1, :], reach)[..., ::-1, :]], axis=-2)
    found, channels = np.empty(y.shape), y.shape[-1]
    taps, first = tuple(_weight(j, -part) for j in TAPS), reach - TAPS[-1] - whole
    _interpolate(wide.reshape(-1, wide.shape[-2] * channels), taps, first * channels, channels, found.reshape(-1, y.shape[-2] * channels))
    return found


@njit(cache=True, nogil=True, error_model="numpy")
def _interpolate(y, taps, first, apart, found):
    """Fills (K, m) with what taps make of (K, more), from the first on, of which neighbours are so far apart.

    The last tap is added first and nothing is fused: so readings are those of `scipy.ndimage.correlate1d` to the bit, on any processor.
    """
    first, apart = np.uint64(first), np.uint64(apart)  # for no index that may be negative makes a fast loop
    for k in range(len(found)):
        for i in range(found.shape[1]):
            at = first + np.uint64(i)
            total = taps[-1] * y[k, at + np.uint64(len(taps) - 1) * apart]
            for j in range(len(taps) - 1):
                total += taps[j] * y[k, at + np.uint64(j) * apart]
            found[k, i] = total


def beyond(y: np.ndarray, count: int) -> np.ndarray:
    """(..., count, channels) before the first reading, straight on."""
    back = np.arange(count, 0, -1)[:, None]
    return y[..., :1, :] - back * (y[..., 1:2, :] - y[..., :1, :])


def _weight(j: int, x: float) -> float:
    """Lagrange polynomial of a tap at x."""
    return math.prod((x - other) / (j - other) for other in TAPS if other != j)


def slope(y: np.ndarray, step: float, starts: Sequence[int] = ()) -> np.ndarray:
    """(..., n, channels) time derivative of (..., n, channels), of each piece for itself and less what it is where that starts."""
    n = y.shape[-2]
    found = np.empty_like(y)
    found[..., 1:-1, :] = (y[..., 2:, :] - y[..., :-2, :]) * (0.5 / step)
    first = np.array([start for start in (starts or (0,)) if start + 1 < n])
    last = np.append(first[1:], n) - 1
    found[..., first, :] = (y[..., first + 1, :] - y[..., first, :]) / step
    found[..., last, :] = (y[..., last, :] - y[..., last - 1, :]) / step
    if starts:
        found[..., first[0] :, :] -= np.repeat(found[..., first, :], last + 1 - first, axis=-2)
    return found
