"""What was measured on one machine: drives and sensor readings at even times. Nothing else ever reaches the workflow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from hamr_description.errors import BagError

from .resample import resampled

SAME = 1e-4  # of a step, by which those of two records of one machine may differ


@dataclass(frozen=True, eq=False)
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
        uneven: of a step, the most that one of those measured was longer or shorter, where these samples lie between the measured ones.
        rounding: (channels,) standard deviation of the rounding of these measured ones, which samples between them hide.
        shaken: share of the samples that were left out, NaN, for an end stop had been hit just before.
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
    uneven: float = 0.0
    rounding: tuple[float, ...] = ()
    shaken: float = 0.0

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
        if other.channels != first.channels or not np.isclose(other.step, first.step, rtol=SAME):
            raise BagError("Records of one machine must have the same sensors and the same time step: resample them or leave one out.")
    starts = np.cumsum([0, *(len(r) for r in records)])
    breaks = tuple(int(b + start) for r, start in zip(records, starts, strict=False) for b in (0, *r.breaks) if b + start)
    return replace(
        first, drives=np.concatenate([r.drives for r in records]), readings=np.concatenate([r.readings for r in records]),
        rest=all(r.rest for r in records), breaks=breaks, uneven=max(r.uneven for r in records),
        rounding=tuple(max(each) for each in zip(*(r.rounding for r in records if r.rounding), strict=True)),
        shaken=float(np.average([r.shaken for r in records], weights=[len(r) for r in records])),
    )  # fmt: skip
