"""The two ends of the servo bus as objects: bounded waits, peers that die, fall silent and come back."""

from __future__ import annotations

import os
from enum import Enum

import numpy as np
from numba import njit

from hamr_description.rates import SUBSTEPS

from . import answers, bus
from .answers import SLICE_NS
from .atomics import load_acquire, store_release
from .bus_file import BusFile, BusTaken, Role, bus_path, create, remove
from .law import NEUTRAL_VOLT
from .plan import Plan

_NEUTRAL = Plan.neutral().memory


@njit(cache=True)
def _word(words, index):
    return load_acquire(words, index)


@njit(cache=True)
def _set_word(words, index, value):
    store_release(words, index, value)


class Reply(Enum):
    """What the simulator knows about the answer to a period's first sample."""

    READY = "answered"
    WAITING = "not answered yet"
    ABSENT = "no driver"


class Progress(Enum):
    """How far a driver has come with a period."""

    DONE = "all samples answered"
    PENDING = "the simulator keeps the next sample back"
    LOST = "the simulator went, or went on without us"


class SimulatorEnd:
    """The simulator's end; makes the bus.

    A driver is absent when it is dead, or was silent for longer than the patience; it is back when it joins anew or answers late.
    Whatever an absent driver leaves unanswered is filled with the neutral voltage.

    Args:
        run: name of the run, part of the file's name.
        patience_s: longest wait for one answer within a period, wall time.

    Raises:
        BusTaken: a living simulator has the bus of this run.
    """

    waits = True

    def __init__(self, run: str, *, patience_s: float = 1.0):
        bus.warm_up()
        answers.over_the_bus()
        self._file = create(bus_path(run))
        self._words, self._reals = self._file.words, self._file.reals
        self._slices = max(1, round(patience_s * 1e9 / SLICE_NS))
        self._first = 0
        self._left: tuple[int, int] | None = self._mark()  # the mark at which the driver was given up; None while it is there

    def _mark(self) -> tuple[int, int]:
        return _word(self._words, bus.JOINS_WORD), _word(self._words, bus.ANSWER_WORD)

    def offer(self, period: int, sample: np.ndarray) -> None:
        """Publish the first sample (7, 8) of a period."""
        self._first = bus.first_number(period)
        bus.post_sample(self._words, self._reals, self._first, sample)

    def poll(self, volts: np.ndarray) -> Reply:
        """Wait a little for the voltages (8,) of the first sample; at once ABSENT, with the neutral voltage, where no driver is."""
        if self._left is not None and self._left != self._mark():
            self._left = None
        if self.present:
            bus.await_answer(self._words, self._first, 1, SLICE_NS)
            if bus.take_answer(self._words, self._reals, self._first, volts):
                return Reply.READY
            if self._file.held(Role.DRIVER):
                return Reply.WAITING
        self.give_up(volts)
        return Reply.ABSENT

    def answer(self, k: int, sample: np.ndarray, volts: np.ndarray) -> None:
        """Exchange sample k >= 1 (7, 8) for voltages (8,), which are neutral where no driver answers."""
        if self.present:
            for _ in range(self._slices):
                if bus.exchange(self._words, self._reals, self._first + k, sample, volts, SLICE_NS):
                    return
                if not self._file.held(Role.DRIVER):
                    break
        self.give_up(volts)

    @property
    def present(self) -> bool:
        """Whether a driver is there."""
        return self._left is None

    def compiled(self) -> tuple[object, np.ndarray]:
        """Callback and memory (hamr_controller.answers) that answer as `answer` does, but for the patience."""
        return (answers.over_the_bus(), self._reals) if self.present else (answers.by_plan(), _NEUTRAL)

    def give_up(self, volts: np.ndarray) -> None:
        """Count the driver as absent; fills volts (8,) with the neutral voltage."""
        if self.present:
            self._left = self._mark()
        volts[:] = NEUTRAL_VOLT

    @property
    def driver_name(self) -> str:
        """The driver that joined last, for messages."""
        return f"The driver (process {_word(self._words, bus.DRIVER_PID_WORD)})"

    def finish(self, volts: np.ndarray) -> None:
        """The period is over; the driver has seen its voltages."""

    def close(self) -> None:
        """Take the bus away; the driver notices."""
        remove(self._file)


class DriverEnd:
    """The driver's end: connects to the bus of a run while its simulator lives, and joins when the driver is ready to answer."""

    def __init__(self, run: str):
        bus.warm_up()
        self._path = bus_path(run)
        self._file: BusFile | None = None
        self.joined = False
        self._seen = 0  # newest sample known
        self._k = 0  # sample of the present period to answer next

    @property
    def connected(self) -> bool:
        """Whether a bus is mapped whose simulator lived when last looked at."""
        return self._file is not None

    def connect(self) -> bool:
        """Map the bus, unless it is; whether its simulator lives. Disconnects if it does not.

        Raises:
            ConfigError: the file is not a servo bus of this version.
        """
        try:
            self._file = self._file or BusFile(self._path)
        except FileNotFoundError:
            return False
        if not self._file.held(Role.SIMULATOR):
            self.leave()
        return self.connected

    def join(self) -> None:
        """Become the driver of the bus connected to.

        Raises:
            BusTaken: another living driver has it.
        """
        words = self._file.words
        if not self._file.lock(Role.DRIVER):
            raise BusTaken(f"Another driver (process {_word(words, bus.DRIVER_PID_WORD)}) is on the servo bus; stop one of the two.")
        _set_word(words, bus.DRIVER_PID_WORD, os.getpid())
        _set_word(words, bus.JOINS_WORD, _word(words, bus.JOINS_WORD) + 1)
        self.joined, self._seen = True, 0

    @property
    def newest_period(self) -> int:
        """Number of the newest period that the simulator offered; -1 before the first and while not connected."""
        return (_word(self._file.words, bus.SAMPLE_WORD) - 1) // SUBSTEPS if self._file else -1

    def next_period(self) -> int | None:
        """Wait a little for a period whose first sample has no answer yet; None if there is none, or the simulator went."""
        words = self._file.words
        if not bus.await_sample(words, self._seen + 1, 1, SLICE_NS):
            self.connect()
            return None
        self._seen, self._k = _word(words, bus.SAMPLE_WORD), 0
        period, k = divmod(self._seen - 1, SUBSTEPS)
        return period if k == 0 else None

    def drive(self, period: int, plan: Plan, volts: np.ndarray) -> Progress:
        """Answer a period by a plan, filling volts (80, 8); to be called again while it is PENDING."""
        words, reals = self._file.words, self._file.reals
        first = bus.first_number(period)
        k = bus.drive(words, reals, first, self._k, plan.feed, plan.target, plan.kp, plan.kd, volts, SLICE_NS)
        if k == bus.LOST:
            return Progress.LOST
        self._k = k
        if k == SUBSTEPS:
            self._seen = first + SUBSTEPS - 1
            return Progress.DONE
        return Progress.PENDING if self.connect() else Progress.LOST

    def leave(self) -> None:
        """Disconnect; the simulator notices."""
        self.joined = False
        if self._file is not None:
            self._file.close()
            self._file = None
