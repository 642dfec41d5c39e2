"""What was measured on one machine: drives and sensor readings at even times. Nothing else ever reaches the workflow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import comb

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import maximum_filter

from hamr_description.errors import BagError

JUMP = 3.0  # a step of the drive this many times the usual one and its neighbours is a jump
NEAR = 5  # samples in which it has neighbours
SELDOM = 0.02  # of all repeats, that other steps are more than if not all is repeated
CATCHES_UP = 0.6  # of the usual step, that steps after repeated samples are at least if those were old ones


@dataclass(frozen=True)
class Record:
    """Measured samples of one machine in its own units.

    Attributes:
        drives: (n * drives_per_reading, joints) U. readings: (n, channels), NaN where a sensor said nothing.
        step: T between samples. channels: names, as `Machine.channels` or some of them.
        drives_per_reading: how many drives each sample has; more than one where the drive was recorded faster than the sensors.
        held: whether a drive holds until the next sample (True) or was sampled from a smooth signal.
        hold: T for which the driver holds each command of such a signal, which is late by half of it.
        rest: whether the machine was at rest before the first sample of each stretch.
        breaks: indices at which a new stretch begins, recorded at another time.
    """

    drives: np.ndarray
    readings: np.ndarray
    step: float
    channels: tuple[str, ...]
    held: bool = False
    hold: float = 0.0
    rest: bool = True
    drives_per_reading: int = 1
    breaks: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        if len(self.drives) != len(self.readings) * self.drives_per_reading:
            raise BagError(f"{len(self.drives)} drives but {len(self.readings)} readings: they must belong to the same times.")
        if not np.isfinite(self.drives).all():
            raise BagError("A drive is NaN or infinite: every sample needs one.")

    def __len__(self) -> int:
        return len(self.readings)

    @cached_property
    def span(self) -> float:
        """Duration, T."""
        return len(self) * self.step

    @cached_property
    def driven(self) -> np.ndarray:
        """(joints,) whether the drive of a joint ever changes."""
        return np.ptp(self.drives, axis=0) > 0.0

    @property
    def stretches(self) -> list[tuple[int, int]]:
        """Start and stop of each part without a break."""
        edges = (0, *self.breaks, len(self))
        return list(zip(edges[:-1], edges[1:], strict=True))

    def fine(self, substeps: int) -> np.ndarray:
        """(n * substeps, joints) drives at the steps of a simulation: in their middle, where smooth, and late; held up to each jump."""
        if self.held or self.drives_per_reading > 1:
            return np.repeat(self.drives, substeps // self.drives_per_reading, axis=0)
        parts, within = [self.drives[start:stop] for start, stop in self.stretches], 0.5 - 0.5 * self.hold / self.step * substeps
        return np.concatenate([np.stack([resampled(u, substeps, within=within) for u in part.T], 1) for part in parts])

    def averaged(self, mean: int) -> np.ndarray:
        """(n // mean, channels) readings, means over `mean` samples each; NaN where one is missing."""
        n = len(self) // mean
        return self.readings[: n * mean].reshape(n, mean, -1).mean(1)

    def cut(self, start: int, stop: int) -> Record:
        """Samples start to stop; not from rest unless from the beginning."""
        per = self.drives_per_reading
        return replace(
            self, drives=self.drives[start * per : stop * per], readings=self.readings[start:stop],
            rest=self.rest and start == 0, breaks=tuple(b - start for b in self.breaks if start < b < stop),
        )  # fmt: skip


def joined(records: Sequence[Record]) -> Record:
    """Several records of one machine as one, in stretches; from rest if all are.

    Raises:
        BagError: they differ in step or channels.
    """
    first = records[0]
    for other in records[1:]:
        if other.channels != first.channels or not np.isclose(other.step, first.step, rtol=1e-4):
            raise BagError("Records of one machine must have the same sensors and the same time step: resample them or leave one out.")
    starts = np.cumsum([0, *(len(r) for r in records)])
    breaks = tuple(int(b + start) for r, start in zip(records, starts, strict=False) for b in (0, *r.breaks) if b + start)
    return replace(
        first, drives=np.concatenate([r.drives for r in records]), readings=np.concatenate([r.readings for r in records]),
        rest=all(r.rest for r in records), breaks=breaks,
    )  # fmt: skip


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


def noise_of(x: np.ndarray) -> np.ndarray:
    """(channels,) standard deviation of white noise in (n, channels) samples of smooth signals, from differences.

    Differences of order m leave noise of variance C(2m, m) and ever less of the signal: the least over the orders is taken, but no
    less than the rounding of a sensor with steps, which looks free of noise where it rests on one of them.
    """
    best = np.full(x.shape[1], np.inf)
    for order in range(1, 9):
        d = np.diff(x, order, axis=0)
        d = d[np.isfinite(d).all(1)]
        if len(d) < 30:
            break
        best = np.minimum(best, 1.4826 * np.median(np.abs(d), axis=0) / np.sqrt(comb(2 * order, order)))
    return np.maximum(best, [rounding(column) for column in x.T])


def rounding(x: np.ndarray) -> float:
    """Standard deviation of the rounding of (n,) samples, zero where they are no multiples of a step."""
    levels = np.unique(x[np.isfinite(x)])
    steps = np.diff(levels)
    steps = steps[steps > 1e-9 * np.ptp(levels)] if len(levels) > 1 else steps  # decimals differ in their last bits
    if not len(steps):
        return 0.0
    count = steps / steps.min()
    return float(steps.min() / np.sqrt(12)) if np.median(np.abs(count - np.round(count))) < 0.01 else 0.0
