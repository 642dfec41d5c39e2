"""A machine under a record's drives: runs of many parameter sets, as the record's sensors would have read them."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from hamr_dynamics import machine_kernel
from hamr_dynamics.effects.law import Scales
from hamr_dynamics.machine import Machine

from ..data.record import Record
from .parameters import Free, lanes
from .pieces import Pieces, pieces_of
from .sensors import beyond, late

LATEST = 0.1  # of a record: a fit that makes its clocks later than that is lost anyway
EDGE = 16  # readings on either side of a break that serve nothing: clocks that are late by less read across it
START = "start"  # of the names of what moves the starts of pieces
BAND = 1000.0  # readings a second that are kept: what HAMR's legs do is slower


@dataclass
class Model:
    """A machine and one record of it.

    Attributes:
        substeps: steps per sample. mean: samples averaged into one reading.
        scales: what is usual on this machine. piece: T of a piece, 0 for what suits the machine.
        delay: T by which readings are late, in whole steps, and `LATEST` at most: what is read is the machine's state so much before.
        begins: whether a fit may move the starts of pieces: over long ones what a measured start is off by is no longer small.
        target: (n, channels) averaged readings, NaN where none is, or where a late one shows what was before the record.
        own: indices of the record's channels among the machine's.
        pieces: parts that start anew, None for free runs from rest. wanted: (S,) which of these are run.
    """

    machine: Machine
    record: Record
    substeps: int
    mean: int
    scales: Scales
    piece: float = 0.0
    delay: float = 0.0
    begins: bool = False
    pieces: Pieces | None = field(init=False)
    wanted: np.ndarray = field(init=False)
    target: np.ndarray = field(init=False)
    own: list[int] = field(init=False)
    drives: np.ndarray = field(init=False)
    neutral: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        most = len(self.record) * self.substeps * LATEST
        self._late = round(float(np.clip(self.delay * self.substeps / self.record.step, -most, most)))
        self.delay = self._late * self.record.step / self.substeps
        self.target = self.record.averaged(self.mean)
        self.own = [self.machine.channels.index(name) for name in self.record.channels]
        fine = self.record.fine(self.substeps)
        self.drives = np.concatenate([fine, np.repeat(fine[-1:], max(-self._late, 0), axis=0)])  # clocks ahead see beyond the end
        self.neutral = self.machine.neutral(self.scales)
        self.pieces = pieces_of(self.machine, self.record, self.mean, self.piece)
        self.wanted = np.ones(len(self.pieces or ()), bool)
        if self.pieces is not None:
            # a piece's first and last reading serve nothing: their slopes reach into its neighbours
            served = np.zeros(len(self.target), bool)
            for start, stop in zip(self.pieces.first, self.pieces.stop, strict=True):
                served[start + 1 : stop - 1] = True
            self.target = np.where(served[:, None], self.target, np.nan)
        else:
            for start, _ in self.stretches:
                inner = EDGE if start else 0
                self.target[max(start - inner, 0) : start + max(inner, self._unseen)] = np.nan

    def only(self, readings: np.ndarray) -> Model:
        """The same in pieces, of which none is run that holds none of some readings, (n,)."""
        other = copy(self)
        other.wanted = np.array([readings[a:b].any() for a, b in self.pieces.parts])
        return other

    @property
    def stretches(self) -> list[tuple[int, int]]:
        """First reading and the one after the last of each stretch."""
        return [(-(-start // self.mean), stop // self.mean) for start, stop in self.record.stretches]

    @property
    def _unseen(self) -> int:
        """Readings at the beginning of a stretch that show what was before the record."""
        return max(0, -(-self._late // (self.mean * self.substeps)))

    @property
    def reading_step(self) -> float:
        """T between averaged readings."""
        return self.record.step * self.mean

    @cached_property
    def starts(self) -> tuple[int, ...]:
        """Readings from which runs start as measured, of a machine that does not forget it."""
        return () if self.pieces is None or self.pieces.forgotten else tuple(int(x) for x in self.pieces.first)

    @property
    def free_starts(self) -> list[Free]:
        """Free numbers that move the coordinates and rates at the starts of pieces, if a fit may."""
        if not (self.begins and self.starts):
            return []
        scales, joints = self.scales, len(self.machine.joints)
        usual = [*[scales.coordinate] * joints, *[scales.coordinate / scales.time] * joints] * len(self.pieces)
        return [Free(f"{START}.{k}", scale, -np.inf, np.inf, 0.0, 1.0) for k, scale in enumerate(usual)]

    def with_starts(self, free: Sequence[Free], x: np.ndarray) -> tuple[list[Free], np.ndarray]:
        """Free numbers with their values, of another length of pieces, and behind them what moves the starts of these, as measured."""
        own, moving = [k for k, f in enumerate(free) if not f.row.startswith(START)], self.free_starts
        return [*(free[k] for k in own), *moving], np.concatenate([x[own], np.zeros(len(moving))])

    def rows(self, free: Sequence[Free], x: np.ndarray) -> np.ndarray:
        """(K, rows) lane parameters of (K, P) or (P,) free numbers, and behind them what moves starts, if any of these does.

        Those of another record's pieces move none here.
        """
        names = [*self.machine.parameter_rows, *(f.row for f in self.free_starts)]
        neutral = np.concatenate([self.neutral, np.zeros(len(names) - len(self.neutral))])
        own = [k for k, f in enumerate(free) if self.begins or not f.row.startswith(START)]
        return lanes(names, neutral, [free[k] for k in own], np.atleast_2d(x)[:, own])

    def runs(self, free: Sequence[Free], x: np.ndarray, samples: int | None = None) -> np.ndarray:
        """(K, n, channels) of (K, P) parameter sets; the first `samples` readings if said."""
        return self.run_rows(self.rows(free, x), samples)

    @cached_property
    def plain(self) -> np.ndarray:
        """(n, channels) of the machine as given, its sensors on time."""
        return late(self.runs((), np.zeros(0))[0], -self.delay, self.reading_step, self.starts)

    def run_rows(self, rows: np.ndarray, samples: int | None = None) -> np.ndarray:
        """(K, n, channels) of (K, rows) lane parameters; the first `samples` readings if said."""
        samples, step = samples or len(self.target), self.record.step / self.substeps
        return self._free(rows, samples, step) if self.pieces is None else self._piecewise(self.pieces, rows, samples, step)

    def _free(self, rows: np.ndarray, samples: int, step: float) -> np.ndarray:
        """As `run_rows`, each stretch from rest; straight on back to readings that show what was before."""
        whole = np.zeros((len(rows), samples, len(self.own)))
        for (begin, _), (start, stop) in zip(self.record.stretches, self.stretches, strict=True):
            if (count := min(stop, samples) - start) > self._unseen:
                read = (start + self._unseen) * self.mean * self.substeps
                y = self._from_rest(rows, begin * self.substeps, read, count - self._unseen, step)
                y = np.concatenate([beyond(y, self._unseen), y], axis=1) if self._unseen else y
                if count == samples:
                    return y
                whole[:, start : start + count] = y
        return whole

    def _from_rest(self, rows: np.ndarray, begin: int, read: int, readings: int, step: float) -> np.ndarray:
        """(K, readings, channels) of a machine that is at rest at step `begin`, from the step on that is read at step `read`."""
        start = np.zeros((len(rows), len(self.machine.state_rows)))
        start[:, self.machine.state_rows.index("time")] = begin * step
        first, begun = np.full(len(rows), begin), read - self._late - begin
        if begun:
            start = machine_kernel.final_states(self.machine, self.drives, rows, step=step, steps=begun, first=first, start=start)
        return machine_kernel.simulate(
            self.machine, self.drives, rows, step=step, substeps=self.substeps, mean=self.mean,
            first=first + begun, start=start, samples=readings, channels=self.own,
        )  # fmt: skip

    def _piecewise(self, pieces: Pieces, rows: np.ndarray, samples: int, step: float) -> np.ndarray:
        """As `run_rows`, every piece in a lane of its own; zero where none is run."""
        chosen = np.flatnonzero(self.wanted & (pieces.first < samples))
        first, stop = pieces.first[chosen], np.minimum(pieces.stop[chosen], samples)
        longest, steps = int((stop - first).max()), self.mean * self.substeps
        drives, count = self._reaching(longest * steps), len(self.neutral)
        param = np.repeat(rows[:, :count], len(chosen), axis=0)
        state = self._started(pieces, chosen, drives, param, step)
        if moved := rows.shape[1] - count:
            by = rows[:, count:].reshape(len(rows), len(pieces), moved // len(pieces))[:, chosen]
            state[:, : by.shape[2]] += by.reshape(-1, by.shape[2])
        y = machine_kernel.simulate(
            self.machine, drives, param, step=step, substeps=self.substeps, mean=self.mean, samples=longest,
            first=np.tile(first * steps, len(rows)), start=state, channels=self.own,
        )  # fmt: skip
        y = y.reshape(len(rows), len(chosen), longest, -1)
        whole = np.zeros((len(rows), samples, y.shape[-1]))
        for k, (a, b) in enumerate(zip(first, stop, strict=True)):
            whole[:, a:b] = y[:, k, : b - a]
        return whole

    def _reaching(self, steps: int) -> np.ndarray:
        """(n + steps, joints) drives of a machine that is read late, and on beyond the end, as short pieces run."""
        before, after = np.repeat(self.drives[:1], max(self._late, 0), axis=0), np.repeat(self.drives[-1:], steps, axis=0)
        return np.concatenate([before, self.drives[max(-self._late, 0) :], after])

    def _started(self, pieces: Pieces, chosen: np.ndarray, drives: np.ndarray, param: np.ndarray, step: float) -> np.ndarray:
        """(K * S, states) at the starts of the chosen pieces: coordinates and rates as measured, the rest as a run-in leaves it."""
        sets, steps = len(param) // len(chosen), self.mean * self.substeps
        first, lead = pieces.first[chosen], pieces.lead[chosen]
        motion, time = slice(0, pieces.start.shape[1]), self.machine.state_rows.index("time")
        state = np.zeros((len(chosen), len(self.machine.state_rows)))
        state[:, motion], state[:, time] = pieces.before[chosen], (first - lead) * self.reading_step
        state = np.tile(state, (sets, 1))
        led = np.flatnonzero(np.tile(lead > 0, sets))
        if len(led):
            state[led] = machine_kernel.final_states(
                self.machine, drives, param[led], step=step, steps=int(lead.max()) * steps,
                first=np.tile((first - lead) * steps, sets)[led], start=state[led],
            )  # fmt: skip
        state[:, motion] = np.tile(pieces.start[chosen], (sets, 1))
        return state
