"""Angles, rates and accelerations from readings of angles alone: zero-phase low-pass, then splines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import butter, sosfiltfilt

from hamr_description.errors import BagError

from ...data.readings import noise_of
from ...fitting.weighed import Sensors
from ...naming.prepare import Prepared

ORDER = 4  # of the filter, run forth and back
CUTOFFS = np.geomspace(0.003, 0.2, 25)  # per sample
REMOVES = 1.1  # of the noise: a filter that removes no more leaves the signal whole
ENDS = 5  # such periods at both ends that the filter can only guess at
WIDER = 2.0  # the filter of the motion against the one of the forces, so that the latter alone forms the band


@dataclass(frozen=True)
class Motion:
    """A record's motion.

    Attributes:
        state: (n, 3 joints) coordinates, rates, accelerations at the samples, as the machine has them (the sensors' part undone).
        tips: (n, other channels) what the other sensors read, likewise.
        cutoff: per sample, below which there is more signal than noise.
        known: (n,) False within and about gaps that the filter cannot bridge, and at both ends.
    """

    state: np.ndarray
    tips: np.ndarray
    cutoff: float
    known: np.ndarray


def motion_of(prepared: Prepared) -> Motion:
    """The motion of a record under the sensors of its re-tune.

    Raises:
        BagError: the record has breaks, over which nothing can be filtered.
    """
    model, sensors = prepared.weighed.model, prepared.base.fit.sensors
    record, n = model.record, len(model.machine.joints)
    if record.breaks:
        raise BagError("The record breaks off and begins again: a filter needs one stretch.")
    gaps = np.isnan(record.readings).any(1)
    whole = np.stack([_bridged(x) for x in record.readings.T], 1)
    cutoff = max(cutoff_of(x, sigma) for x, sigma in zip(whole[:, :n].T, noise_of(record.readings)[:n], strict=True))
    smooth = low_pass(whole, min(WIDER * cutoff, 0.45))
    time = np.arange(len(whole)) * record.step
    curve = CubicSpline(time, unread(sensors, smooth, record.step))
    found = [curve(time, order) for order in range(3)]
    return Motion(np.hstack([x[:, :n] for x in found]), found[0][:, n:], cutoff, ~_about(gaps, cutoff))


def unread(sensors: Sensors, readings: np.ndarray, step: float) -> np.ndarray:
    """(n, channels) motion that sensors would have read so: their answer to an impulse, undone frequency by frequency."""
    n = 2 * len(readings)
    impulse = np.zeros((n, readings.shape[1]))
    impulse[n // 2] = 1.0
    answer = np.fft.rfft(np.roll(sensors.read(impulse, step) - sensors.bias, -(n // 2), axis=0), axis=0)
    centred = readings - sensors.bias
    mirrored = np.concatenate([centred, centred[::-1]])  # no jump from the end to the beginning
    return np.fft.irfft(np.fft.rfft(mirrored, axis=0) / answer, n, axis=0)[: len(readings)]


def cutoff_of(x: np.ndarray, sigma: float) -> float:
    """The lowest cut-off, per sample, at which a low-pass of (n,) samples removes no more than their noise."""
    for cutoff in CUTOFFS:
        removed = x - low_pass(x[:, None], cutoff)[:, 0]
        if 1.4826 * np.median(np.abs(removed)) <= REMOVES * sigma:
            return float(cutoff)
    return float(CUTOFFS[-1])


def low_pass(x: np.ndarray, cutoff: float) -> np.ndarray:
    """(..., n, columns) without what is faster than a cut-off per sample; all of it where that is beyond reach."""
    return sosfiltfilt(butter(ORDER, 2.0 * cutoff, output="sos"), x, axis=-2) if cutoff < 0.45 else x


def _bridged(x: np.ndarray) -> np.ndarray:
    known = np.isfinite(x)
    at = np.arange(len(x))
    return np.interp(at, at[known], x[known])


def _about(gaps: np.ndarray, cutoff: float) -> np.ndarray:
    """True in gaps of a quarter of the filter's shortest period or more, within a period of them, and near the ends."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], gaps.astype(int), [0]])))
    about = np.zeros(len(gaps), bool)
    reach = int(1.0 / cutoff)
    about[: ENDS * reach] = about[-ENDS * reach :] = True
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        if stop - start >= 0.25 / cutoff:
            about[max(0, start - reach) : stop + reach] = True
    return about
