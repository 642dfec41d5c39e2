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
        self._compiled = getattr(engine, "servo_period", None)  # see hamr_controller.answers
        self._warm_up()

    def _warm_up(self) -> None:
        """Whatever the engine compiles at its first step belongs before the first period."""
        self.engine.measure(self.samples[0])
        self.engine.base(self.base)
        self.engine.substep(np.full(len(JOINTS), NEUTRAL_VOLT))
        if self._compiled:
            self._compiled(answers.over_the_bus(), np.zeros(0), self.samples, self.volts, SUBSTEPS)
            self._compiled(answers.by_plan(), np.zeros(0), self.samples, self.volts, SUBSTEPS)
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
        engine, end, samples, volts = self.engine, self.end, self.samples, self.volts
        engine.substep(volts[0])
        k = 1
        while k < SUBSTEPS:
            if self._compiled:
                k = self._compiled(*end.compiled(), samples, volts, k)
                if k == SUBSTEPS:
                    break
            else:
                engine.measure(samples[k])
            end.answer(k, samples[k], volts[k])
            engine.substep(volts[k])
            k += 1
        end.finish(volts)
        self.period += 1

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
