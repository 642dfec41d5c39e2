"""What readings say about their sensor: its noise, its steps, and which of them it has sent twice."""

from __future__ import annotations

from dataclasses import replace
from math import comb

import numpy as np

from .record import Record

SELDOM = 0.02  # of all repeats, that other steps are more than if not all is repeated
CHANCE = 2.0  # over the root of the number of samples: share by which two estimates of one noise differ
CATCHES_UP = 0.6  # of the usual step, that steps after repeated samples are at least if those were old ones


def fresh(record: Record) -> Record:
    """The record without samples that repeat the one before in every channel: whoever sent them had nothing new.

    Sensors with coarse steps may say the same twice; where all are such, all stays. So it does where the steps after repeats are small:
    then the machine stood still, or coarse readings were resampled, while what was kept back catches up with a step as large as any.
    """
    if all(rounding(column) > 0.0 for column in record.readings.T):
        return record
    step = np.abs(np.diff(record.readings, axis=0))
    same = (step == 0.0).all(1)
    after = np.append(False, same[:-1]) & ~same
    usual = ~same & ~after & np.isfinite(step).all(1)
    if usual.sum() > SELDOM * same.sum():  # or all is sent several times, by a sensor slower than its clock
        caught_up = np.nanmedian(step[after], axis=0) if after.any() else 0.0
        if np.mean(caught_up / np.maximum(np.median(step[usual], axis=0), 1e-300)) < CATCHES_UP:
            return record
    return replace(record, readings=np.where(np.append(False, same)[:, None], np.nan, record.readings))


def sensor_noise(record: Record) -> np.ndarray:
    """(channels,) standard deviation of a sample's noise, rounding included."""
    return np.maximum(noise_of(record.readings), record.rounding or 0.0)


def noise_of(x: np.ndarray, *, chance: float = CHANCE) -> np.ndarray:
    """(channels,) standard deviation of white noise in (n, channels) samples of smooth signals, from differences.

    Differences of order m leave noise of variance C(2m, m) and ever less of the signal: the first order is taken that leaves no more than
    the least of all does, but for chance, for the least of several is too small by chance. It is no less than the rounding of a sensor with
    steps, which looks free of noise where it rests on one of them. What stands still for most of the time is judged by where it moves.

    Args:
        chance: share by which two estimates differ, times the root of n; none for few samples of what moves fast, in which every order has
            some of the signal left and the least is not too small.
    """
    found = []
    for order in range(1, 9):
        d = np.diff(x, order, axis=0)
        d = d[np.isfinite(d).all(1)]
        if len(d) < 30:
            break
        found.append(1.4826 * np.array([_usual(c) for c in np.abs(d).T]) / np.sqrt(comb(2 * order, order)))
    if not found:
        return np.full(x.shape[1], np.inf)
    spread = np.array(found)
    close = spread <= spread.min(0) * (1.0 + chance / np.sqrt(len(x)))
    return np.maximum(spread[close.argmax(0), range(x.shape[1])], [rounding(column) for column in x.T])


def _usual(sizes: np.ndarray) -> float:
    """Median of (n,) sizes; of those that are not zero, where most are."""
    moved = sizes[sizes > 0.0]
    return float(np.median(sizes) or (np.median(moved) if len(moved) else 0.0))


def rounding(x: np.ndarray) -> float:
    """Standard deviation of the rounding of (n,) samples, zero where they are no multiples of a step."""
    levels = np.unique(x[np.isfinite(x)])
    steps = np.diff(levels)
    steps = steps[steps > 1e-9 * np.ptp(levels)] if len(levels) > 1 else steps  # decimals differ in their last bits
    if not len(steps):
        return 0.0
    count = steps / steps.min()
    return float(steps.min() / np.sqrt(12)) if np.median(np.abs(count - np.round(count))) < 0.01 else 0.0
