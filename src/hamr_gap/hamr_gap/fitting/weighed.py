"""A model with the readings that count, and the sensors solved for with every run of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..data.motion import measured_by
from .initial_states import InitialStates
from .model import Model
from .pieces import telling
from .sensors import Sensors, late, slope

SMALLEST = 0.25  # rms in noise of a sample: a gap below it is none, whatever its significance
INDEPENDENT = 100  # readings, as which those count that show a wrong model
GAIN_SD = 0.01  # of a sensor's scale, which calibration leaves uncertain by a per cent


@dataclass(frozen=True)
class Weighed:
    """A model with the readings that count and their noise: what a fit is about.

    Attributes:
        coarse: the same model with as few steps as it bears, for the many runs of a screening; None for the model itself.
        chosen: (n, channels) readings that count. sigma: (channels,) noise of an averaged reading.
        numerical: rms by which halving the step moves readings, in units of a sample's noise.
        gains: channels whose gain is free: all of two coupled joints; of one joint, where it is the drive's, those beside it.
        initial: what other initial states of the pieces can do; None where there are none to be solved for.
        shorter: the same in pieces of half the length, of pieces that were doubled.
    """

    model: Model
    chosen: np.ndarray
    sigma: np.ndarray
    gains: tuple[int, ...]
    coarse: Model | None = None
    numerical: float = 0.0
    initial: InitialStates | None = None
    shorter: Weighed | None = None

    @property
    def least(self) -> float:
        """Mean square, in units of a reading's noise, below which a gap is none: a quarter of a sample's noise, or half its error."""
        return self.model.mean * max(SMALLEST, 0.5 * self.numerical) ** 2

    @cached_property
    def until(self) -> int:
        """Readings up to the last that counts, or the end of its piece: further than that a fit need not simulate."""
        last = int(np.flatnonzero(self.chosen.any(1))[-1]) + 1
        return min((stop for _, stop, _ in self.initial.parts if stop >= last), default=last) if self.initial else last

    @cached_property
    def _places(self) -> np.ndarray:
        """(m,) where the readings that count lie in a run laid out flat."""
        return np.flatnonzero(self.chosen[: self.until])

    @cached_property
    def _weight(self) -> np.ndarray:
        """(m,) one over the noise of each reading that counts."""
        return 1.0 / self.sigma[self._places % len(self.sigma)]

    @cached_property
    def _gained(self) -> np.ndarray:
        """(m, gains) one where a reading that counts is of a channel whose gain is free."""
        return np.eye(len(self.sigma))[self._places % len(self.sigma)][:, list(self.gains)]

    def vector(self, y: np.ndarray) -> np.ndarray:
        """Weighted readings that count, (m,), of (n, channels) or (K, m) of (K, n, channels), n at least `until`."""
        return self.beside(y).reshape(*y.shape[:-2], y.shape[-2] * y.shape[-1]).take(self._places, axis=-1) * self._weight

    def beside(self, y: np.ndarray) -> np.ndarray:
        """Readings or differences of them, (..., n, channels), less what other initial states make of them."""
        return self.initial.beside(y) if self.initial else y

    def left(self, reading: np.ndarray) -> np.ndarray:
        """(n, channels) of what readings miss the measured ones by, in units of the noise."""
        return self.beside(self.model.target[: len(reading)] - reading) / self.sigma

    @cached_property
    def biased(self) -> tuple[int, ...]:
        """Channels whose bias is free: not those by which joints start as measured, each time anew."""
        began = measured_by(self.model.machine, self.model.record).values() if self.model.starts else ()
        return tuple(sorted(set(range(len(self.sigma))) - {c for c, _ in began}))

    def missed(self, reading: np.ndarray) -> np.ndarray:
        """(channels,) rms, in units of the noise, by which readings (n, channels), n at least `until`, miss those that count; NaN of a
        channel that has none, as where a run diverges at once."""
        square = np.where(self.chosen[: len(reading)], self.left(reading), np.nan) ** 2
        count = (~np.isnan(square)).sum(axis=0)
        return np.sqrt(np.divide(np.nansum(square, axis=0), count, out=np.full(len(count), np.nan), where=count > 0))

    @property
    def sensor_count(self) -> int:
        """Columns of `sensor_columns`."""
        return len(self.biased) + len(self.gains) + 1

    @cached_property
    def in_pieces(self) -> Weighed:
        """The same in short runs, each from a measured start, of what runs freely."""
        length = telling(self.model.machine, self.model.record)
        short = self._remade(lambda model: replace(model, piece=length))
        return replace(short, chosen=self.chosen & np.isfinite(short.model.target), initial=None)

    @cached_property
    def fitted(self) -> Weighed:
        """The same without the pieces in which no reading counts: what a fit need simulate."""
        if self.model.pieces is None:
            return self
        count = self.chosen.any(1)
        return self._remade(lambda model: model.only(count))

    def on_time(self, delay: float) -> Weighed:
        """With the clocks' shift, T, in the model, so that what sensors do besides is done to what they see."""
        timed = self._remade(lambda model: replace(model, delay=delay))
        return replace(timed, chosen=self.chosen & np.isfinite(timed.model.target))

    def _remade(self, change: Callable[[Model], Model]) -> Weighed:
        """The same with its models changed, which are one if they were."""
        model = change(self.model)
        return replace(self, model=model, coarse=model if self.coarse is self.model else self.coarse and change(self.coarse))

    def moved(self, run: np.ndarray, shift: float) -> np.ndarray:
        """A run as late as it is read, about which sensors are linear; in short pieces, which are moved to first order, about no shift."""
        return run if self.model.starts else late(run, shift, self.model.reading_step)

    def sensor_columns(self, run: np.ndarray) -> np.ndarray:
        """(m, biases + gains + 1) derivatives of the weighted readings with respect to the sensors' part, about a run (late already)."""
        step = self.model.reading_step
        if self.initial:  # which mixes the readings of a piece
            gains = self.vector(run * np.eye(run.shape[1])[list(self.gains)][:, None]).T
        else:
            gains = self.vector(run)[:, None] * self._gained
        shift = -step * self.vector(slope(run, step, self.model.starts))[:, None]
        return np.hstack([self._biases, gains, shift])

    @cached_property
    def _biases(self) -> np.ndarray:
        """(m, biases), each in units of its channel's noise, so that columns are alike in size."""
        each = np.eye(len(self.sigma))[list(self.biased)] * self.sigma
        return self.vector(np.broadcast_to(each[:, None], (len(each), self.until, len(self.sigma)))).T

    @cached_property
    def sensor_precision(self) -> np.ndarray:
        """Prior precision of the coefficients of `sensor_columns`: a sensor's scale is known to a per cent, the rest is not."""
        precision = np.full(self.sensor_count, 1e-9)
        precision[len(self.biased) : -1] = GAIN_SD**-2.0
        return precision

    def sensors(self, s: np.ndarray) -> Sensors:
        """Sensors of the coefficients of `sensor_columns`."""
        bias, gain = np.zeros(len(self.sigma)), np.zeros(len(self.sigma))
        biased, gains = list(self.biased), list(self.gains)
        bias[biased] = s[: len(biased)] * self.sigma[biased]
        gain[gains] = s[len(biased) : -1]
        return Sensors(bias, gain, float(s[-1]) * self.model.reading_step)

    def doubt(self, left: np.ndarray) -> float:
        """How much more priors count beside what a model leaves, (m,) as of `vector`, than beside noise alone.

        What is left beyond the noise is no chance: however many readings show it, they say no more than `INDEPENDENT` would. So a
        parameter goes one standard deviation from where it is believed to be for a hundredth of what is left, and ten for no less than all.
        """
        return 1.0 + max(0.0, float(np.mean(left**2)) - 1.0) * len(left) / INDEPENDENT

    def solve_sensors(self, run: np.ndarray, about: float = 0.0, doubt: float = 1.0) -> tuple[np.ndarray, float]:
        """Best sensor coefficients for a run, and the half sum of squares that is left, with their prior; none, and an infinite one, for a
        run that is so far off that nothing else of it is left in a double.

        Args:
            about: shift near which they lie, T. doubt: how much the prior counts.
        """
        about = 0.0 if self.model.starts else about
        moved = self.moved(run, about)
        columns = self.sensor_columns(moved)
        residual = self.vector(self.model.target[: len(run)] - moved)
        precision = doubt * self.sensor_precision
        try:
            s = np.linalg.solve(columns.T @ columns + np.diag(precision), columns.T @ residual)
        except np.linalg.LinAlgError:
            return np.zeros(len(precision)), np.inf
        left = 0.5 * float(np.sum((residual - columns @ s) ** 2) + precision @ s**2)
        s[-1] += about / self.model.reading_step
        return s, left
