"""What stands behind the servo bus and gives the voltages; and a bus that is a plain call to it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from . import answers
from .bus_ends import Reply
from .law import NEUTRAL_VOLT
from .plan import Plan

_NEUTRAL = Plan.neutral()


class Driver(Protocol):
    """The leg controller, or an excitation: decides period by period."""

    def plan(self, period: int) -> Plan | None:
        """What to do in a period; None while that is open."""

    def done(self, period: int, volts: np.ndarray) -> None:
        """A period was driven with voltages (80, 8)."""

    def restart(self) -> None:
        """A new simulator was found: its clock starts at 0."""

    def report(self) -> None:
        """Bring the figures in the diagnostics up to date."""


class LocalEnd:
    """The simulator's end (see bus_ends.SimulatorEnd) where the driver lives in the same process."""

    waits = False
    driver_name = "The driver in this process"

    def __init__(self, driver: Driver, ready: Callable[[], bool] = lambda: True):
        """Args: ready, whether the driver may begin; it is ABSENT until then."""
        self._driver, self._ready, self._joined = driver, ready, False
        self._period, self._sample = 0, np.empty(0)
        self._plan: Plan | None = None

    @property
    def newest_period(self) -> int:
        """Number of the newest period that the simulator offered."""
        return self._period

    def offer(self, period: int, sample: np.ndarray) -> None:
        self._period, self._sample, self._plan = period, sample, None

    def poll(self, volts: np.ndarray) -> Reply:
        self._joined = self._joined or self._ready()
        if not self._joined:
            volts[:] = NEUTRAL_VOLT
            return Reply.ABSENT
        self._plan = self._plan or self._driver.plan(self._period)
        if self._plan is None:
            return Reply.WAITING
        self._plan.answer(0, self._sample, volts)
        return Reply.READY

    @property
    def present(self) -> bool:
        return self._plan is not None

    def compiled(self) -> tuple[object, np.ndarray]:
        return answers.by_plan(), (self._plan or _NEUTRAL).memory

    def answer(self, k: int, sample: np.ndarray, volts: np.ndarray) -> None:
        (self._plan or _NEUTRAL).answer(k, sample, volts)

    def give_up(self, volts: np.ndarray) -> None:
        self._plan = None
        volts[:] = NEUTRAL_VOLT

    def finish(self, volts: np.ndarray) -> None:
        if self._plan is not None:
            self._driver.done(self._period, volts)

    def close(self) -> None:
        pass
