"""The leg controller without ROS: targets in, a plan for each period out."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from hamr_description.names import Topic
from hamr_description.rates import TARGET_NS

from .health import Health, Level
from .joints import BadMessage
from .law import HIGHEST_VOLT, LOWEST_VOLT, Gains
from .plan import Plan
from .targets import Targets

_NEUTRAL = Plan.neutral()


class LegController:
    """A Driver that tracks target hip angles, and holds the neutral voltage while there are none.

    Args:
        targets: which targets hold.
        gains: of the leg law; may be replaced between periods.
        health: told about refused messages, missed targets and saturation.
        publish: takes the time (ns) and the voltages (80, 8) of each period driven.
    """

    def __init__(self, targets: Targets, gains: Gains, health: Health, publish: Callable[[int, np.ndarray], None]):
        self.gains = gains
        self._targets, self._health, self._publish = targets, health, publish
        self._driven = self._saturated = 0

    @property
    def following(self) -> bool:
        """Whether targets come."""
        return self._targets.following

    def hear(self, names: Sequence[str], position: Sequence[float], stamp_ns: int, period: int) -> None:
        """A message of targets came in a period; a bad one is refused and changes nothing."""
        try:
            self._targets.accept(names, position, stamp_ns, period * TARGET_NS)
        except BadMessage as error:
            self._health.refuse(str(error))

    def plan(self, period: int) -> Plan | None:
        """See Driver."""
        settled, target = self._targets.decide(period * TARGET_NS)
        if not settled:
            return None
        if target is None:
            self._health.state("targets", Level.WARN, f"No targets on {Topic.LEG_TARGETS}: neutral voltage.")
            self._health.counts["periods without targets"] += 1
            return _NEUTRAL
        self._health.state("targets", Level.OK, "Following targets.")
        return Plan.track(target, self.gains)

    def done(self, period: int, volts: np.ndarray) -> None:
        """See Driver."""
        self._publish(period * TARGET_NS, volts)
        self._driven += volts.size
        self._saturated += np.count_nonzero((volts <= LOWEST_VOLT) | (volts >= HIGHEST_VOLT))

    def report(self) -> None:
        """See Driver."""
        self._health.figures["saturation"] = self._saturated / max(1, self._driven)
        self._health.counts["periods driven"] += self._driven // max(1, _NEUTRAL.feed.size)
        self._driven = self._saturated = 0

    def restart(self) -> None:
        """See Driver."""
        self._targets.forget()
