"""The loop of a node that drives the servo bus: leg controller or excitation."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hamr_description.errors import ConfigError
from hamr_description.names import JOINTS
from hamr_description.rates import SUBSTEPS, TARGET_NS

from ..bus_ends import DriverEnd, Progress
from ..bus_file import BusTaken
from ..driver import Driver
from ..health import Level
from .ports import Diagnostics, Publishers
from .process import Spinner

_IDLE_S = 0.02
_SETTLE_S = 0.5


class DrivingLoop:
    """Connects a driver to the bus whenever there is one, and drives it period by period.

    Args:
        end: the driver's end.
        driver: decides the voltages.
        spinner: runs the node's callbacks in between.
        diagnostics: of the node.
        publishers: of the node.
        ready: whether the driver may join the bus now.
        lossless: keep the pace of the node's listeners.
    """

    def __init__(
        self,
        end: DriverEnd,
        driver: Driver,
        spinner: Spinner,
        diagnostics: Diagnostics,
        publishers: Publishers,
        *,
        ready: Callable[[], bool],
        lossless: bool,
    ):
        self._end, self._driver, self._spinner, self._diagnostics, self._publishers = end, driver, spinner, diagnostics, publishers
        self._ready, self._lossless = ready, lossless
        self._volts = np.zeros((SUBSTEPS, len(JOINTS)))

    def run(self) -> None:
        """Until the process is to stop."""
        while not self._spinner.stopping:
            if self._end.joined or self._join():
                self._drive()
            else:
                self._spinner.once(_IDLE_S)
            self._diagnostics.tick(max(0, self._end.newest_period) * TARGET_NS, self._driver.report)
        self._end.leave()
        self._publishers.settle(_SETTLE_S)

    def _join(self) -> bool:
        tell = self._diagnostics.health.state
        try:
            new = not self._end.connected
            if not self._end.connect():
                tell("bus", Level.WARN, "No simulator: waiting for its servo bus.")
                return False
            if new:
                self._driver.restart()
            if not self._ready():
                return False
            self._end.join()
        except ConfigError as error:
            tell("bus", Level.WARN if isinstance(error, BusTaken) else Level.ERROR, str(error))
            return False
        tell("bus", Level.OK, "Joined the servo bus.")
        return True

    def _drive(self) -> None:
        """One period, if one comes."""
        period = self._end.next_period()
        if period is None:
            self._spinner.once()
            return
        while (plan := self._driver.plan(period)) is None:
            self._spinner.once(_IDLE_S)
            if self._spinner.stopping or self._end.newest_period != period:
                return
        while (progress := self._end.drive(period, plan, self._volts)) is Progress.PENDING:
            self._spinner.once()
            if self._spinner.stopping:
                return
        if progress is Progress.DONE:
            self._driver.done(period, self._volts)
            if self._lossless:
                self._publishers.keep_pace()
        self._spinner.once()
