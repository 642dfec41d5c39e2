"""A machine under a record's drives: free runs of many parameter sets, as the record's sensors would have read them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from hamr_dynamics import machine_kernel
from hamr_dynamics.effects.law import Scales
from hamr_dynamics.machine import Machine

from .parameters import Free, lanes
from .record import Record

BAND = 1000.0  # readings a second that are kept: what HAMR's legs do is slower


@dataclass
class Model:
    """A machine and one record of it.

    Attributes:
        substeps: steps per sample. mean: samples averaged into one reading.
        scales: what is usual on this machine. target: (n, channels) averaged readings.
        own: indices of the record's channels among the machine's.
    """

    machine: Machine
    record: Record
    substeps: int
    mean: int
    scales: Scales
    target: np.ndarray = field(init=False)
    own: list[int] = field(init=False)
    drives: np.ndarray = field(init=False)
    neutral: np.ndarray = field(init=False)
    start: np.ndarray | None = None

    def __post_init__(self) -> None:
        self.target = self.record.averaged(self.mean)
        self.own = [self.machine.channels.index(name) for name in self.record.channels]
        self.drives = self.record.fine(self.substeps)
        self.neutral = self.machine.neutral(self.scales)

    @property
    def reading_step(self) -> float:
        """T between averaged readings."""
        return self.record.step * self.mean

    def rows(self, free: Sequence[Free], x: np.ndarray) -> np.ndarray:
        """(K, rows) lane parameters of (K, P) or (P,) free numbers."""
        return lanes(self.machine, self.neutral, free, np.atleast_2d(x))

    def runs(self, free: Sequence[Free], x: np.ndarray, samples: int | None = None) -> np.ndarray:
        """(K, n, channels) of (K, P) parameter sets; the first `samples` readings if said."""
        return self.run_rows(self.rows(free, x), samples)

    def run_rows(self, rows: np.ndarray, samples: int | None = None) -> np.ndarray:
        """(K, n, channels) of (K, rows) lane parameters; the first `samples` readings if said."""
        y = machine_kernel.simulate(
            self.machine, self.drives, rows, step=self.record.step / self.substeps, substeps=self.substeps, mean=self.mean,
            start=self.start, samples=samples or len(self.target),
        )  # fmt: skip
        return y[:, :, self.own]


def scales_of(machine: Machine, record: Record) -> Scales:
    """What is usual: rms of drive, readings of the joints, their rates, and the force that the drive makes at rest."""
    n = len(machine.joints)
    columns = [record.channels.index(name) for name in machine.channels[:n] if name in record.channels]
    q = record.readings[:, columns] - np.nanmean(record.readings[:, columns], axis=0)
    smooth = np.stack([np.convolve(np.nan_to_num(c), np.ones(5) / 5, "valid") for c in q.T], 1)
    coordinate = float(np.sqrt(np.mean(smooth**2)))
    rate = float(np.sqrt(np.mean(np.diff(smooth, axis=0) ** 2))) / record.step
    drive = float(np.sqrt(np.mean((record.drives - record.drives.mean(0)) ** 2)))
    zero = (0.0,) * n
    force = np.sqrt(np.mean(np.square(machine.terms(zero, zero, zero, (drive,) * n).drive)))
    return Scales(float(force), coordinate, coordinate / rate, drive)
