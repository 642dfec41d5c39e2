"""A driver that plays given voltages: the white-noise run, open loop."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from hamr_description.rates import TARGET_NS

from .health import Health, Level
from .plan import Plan


class Signal(Protocol):
    """Voltages by periods, as hamr_bags.excitation makes them."""

    frames: int

    def frame(self, k: int) -> np.ndarray:
        """(80, 8) V of period k; neutral after the end."""


class Player:
    """A Driver that plays a signal from the first period it is asked for.

    Args:
        signal: what to play.
        health: told how much is left.
        publish: takes the time (ns) and the voltages (80, 8) of each period driven.
    """

    def __init__(self, signal: Signal, health: Health, publish: Callable[[int, np.ndarray], None]):
        self._signal, self._health, self._publish = signal, health, publish
        self._first: int | None = None
        self._left = signal.frames

    def plan(self, period: int) -> Plan:
        """See Driver."""
        self._first = period if self._first is None else self._first
        played = period - self._first
        self._left = max(0, self._signal.frames - played)
        return Plan.open_loop(self._signal.frame(played))

    def done(self, period: int, volts: np.ndarray) -> None:
        """See Driver."""
        self._publish(period * TARGET_NS, volts)

    def restart(self) -> None:
        """See Driver."""
        self._first = None

    def report(self) -> None:
        """See Driver."""
        self._health.figures["periods to play"] = self._left
        self._health.state("signal", Level.OK, "" if self._left else "The signal is over: neutral voltage.")
