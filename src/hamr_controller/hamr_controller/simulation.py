"""One robot and its clock, period by period: the simulator without ROS."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic
from typing import Protocol

import numpy as np

from hamr_description.names import JOINTS
from hamr_description.rates import SUBSTEPS, TARGET_NS

from . import answers
from .bus_ends import Reply
from .law import NEUTRAL_VOLT
from .messages import BASE_SIZE, ROWS
from .plan import Plan

_LAG_S = 0.1  # wall time behind schedule that is given up


class End(Protocol):
    """The simulator's end of the servo bus: `bus_ends.SimulatorEnd`, or `driver.LocalEnd`."""

    waits: bool  # whether poll waits by itself
    driver_name: str
    present: bool  # whether a driver answers

    def offer(self, period: int, sample: np.ndarray) -> None: ...
    def poll(self, volts: np.ndarray) -> Reply: ...
    def answer(self, k: int, sample: np.ndarray, volts: np.ndarray) -> None: ...
    def compiled(self) -> tuple[object, np.ndarray]: ...
    def give_up(self, volts: np.ndarray) -> None: ...
    def finish(self, volts: np.ndarray) -> None: ...
    def close(self) -> None: ...


class Simulation:
    """An engine behind the bus.

    Attributes:
        period: number of the present period, from 0; sim time is a multiple of it and never jumps back.
        samples: (80, 7, 8) SI, the samples of the present period, and of the last one until `measure`.
        volts: (80, 8) V, the voltages that were held after them.
        base: (13,) SI, state of the base at the start of the period.
    """

    def __init__(self, engine, end: End, *, seed: int = 0):
        """Args: engine, as in architecture.md; end, its end of the bus; seed, for every reset."""
        self.engine, self.end, self._seed = engine, end, seed
        self.period = 0
        self.samples = np.zeros((SUBSTEPS, ROWS, len(JOINTS)))
        self.volts = np.zeros((SUBSTEPS, len(JOINTS)))
        self.base = np.zeros(BASE_SIZE)
        self._servo_period = getattr(engine, "servo_period", None)  # see hamr_controller.answers
        self._warm_up()

    def _warm_up(self) -> None:
        """What the engine compiles when it is first used belongs before the first period."""
        self.engine.measure(self.samples[0])
        self.engine.base(self.base)
        self.volts[:] = NEUTRAL_VOLT
        if self._servo_period:
            self._servo_period(answers.by_plan(), Plan.neutral().memory, self.samples, self.volts, 0)
        else:
            self.engine.substep(self.volts[0])
        self.engine.reset(self._seed)

    @property
    def time_ns(self) -> int:
        """Sim time at the start of the present period."""
        return self.period * TARGET_NS

    def measure(self) -> bool:
        """Measure the state at the start of the period; whether it is finite."""
        self.engine.measure(self.samples[0])
        self.engine.base(self.base)
        return bool(np.isfinite(self.samples[0]).all() and np.isfinite(self.base).all())

    def offer(self) -> None:
        """Offer the state to the driver."""
        self.end.offer(self.period, self.samples[0])

    def run(self) -> None:
        """The 80 substeps of the period; `volts[0]` is there (see End.poll)."""
        k = 0
        while (k := self._hold(k)) < SUBSTEPS:
            self.end.answer(k, self.samples[k], self.volts[k])
        self.end.finish(self.volts)
        self.period += 1

    def _hold(self, k: int) -> int:
        """Hold volts[k], and go on as far as the engine can; the sample that is measured and has no voltages yet, or 80."""
        if self._servo_period:
            return self._servo_period(*self.end.compiled(), self.samples, self.volts, k)
        self.engine.substep(self.volts[k])
        if k + 1 < SUBSTEPS:
            self.engine.measure(self.samples[k + 1])
        return k + 1

    def reset(self) -> None:
        """Start anew from the initial state. The clock goes on and leaves a period out, so that everyone sees the cut."""
        self.engine.reset(self._seed)
        self.period += 2


class Pace:
    """Keeps sim time to a multiple of wall time.

    Attributes:
        overruns: how often it fell behind by more than could be made up.
    """

    def __init__(self, factor: float, *, clock: Callable[[], float] = monotonic):
        """Args: factor, sim time over wall time, 0 for as fast as possible; clock, wall time in s."""
        self._clock = clock
        self.overruns = 0
        self.set(factor)

    def set(self, factor: float) -> None:
        """Change the factor from now on."""
        self._step = TARGET_NS * 1e-9 / factor if factor > 0 else 0.0
        self._due = self._clock()

    def remaining(self) -> float:
        """Wall time in s until the next period is due."""
        return max(0.0, self._due - self._clock()) if self._step else 0.0

    def advance(self) -> None:
        """A period begins."""
        self._due += self._step
        if self._step and self._clock() - self._due > _LAG_S:
            self.overruns += 1
            self._due = self._clock()

    def resume(self) -> None:
        """Time stood still on purpose."""
        self._due = max(self._due, self._clock())
