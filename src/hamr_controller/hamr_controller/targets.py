"""Which target hip angles hold in a period: those that answer its state, or none."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from time import monotonic

import numpy as np

from hamr_description.names import JOINTS, Topic
from hamr_description.numbers import value

from .joints import BadMessage, ordered

LIMIT = value("controller.target_limit")  # rad
_REMEDY = f"give targets the stamp of the newest {Topic.JOINT_STATES}"


def checked(names: Sequence[str], position: Sequence[float]) -> np.ndarray:
    """Targets (8,) rad in canonical order, read-only.

    Raises:
        BadMessage: see `ordered`, and an angle outside +-LIMIT.
    """
    target = ordered(Topic.LEG_TARGETS, names, position)
    beyond = np.abs(target) > LIMIT
    if beyond.any():
        j = int(np.argmax(beyond))
        raise BadMessage(f"{Topic.LEG_TARGETS} has {target[j]:.4g} rad for '{JOINTS[j]}'; stay within +-{LIMIT:.4g} rad.")
    target.setflags(write=False)
    return target


class Targets:
    """Targets by the time of the state they answer.

    In lock-step a period waits for the targets that carry its own stamp, up to `patience_s` of wall time; when they fail to come, they
    have stopped, and no period waits any more until targets come again. Without lock-step a period takes the newest targets there are.
    Either way targets that answer a state older than `age_s` of sim time are refused.

    Args:
        lockstep: wait for the answer to each state.
        patience_s: longest wait for an answer, s of wall time.
        age_s: oldest state that targets may answer, s of sim time.
        clock: wall time in s.
    """

    def __init__(self, *, lockstep: bool, patience_s: float, age_s: float, clock: Callable[[], float] = monotonic):
        self._lockstep, self._patience_s, self._age_ns = lockstep, patience_s, round(age_s * 1e9)
        self._clock = clock
        self.forget()

    def forget(self) -> None:
        """As if no targets had ever come; for a clock that starts anew."""
        self._stamp, self._target = -1, np.zeros(len(JOINTS))
        self._following = False
        self._asked, self._asked_at = -1, 0.0

    @property
    def following(self) -> bool:
        """Whether targets come."""
        return self._following

    def accept(self, names: Sequence[str], position: Sequence[float], stamp_ns: int, now_ns: int) -> None:
        """Take a message; of several with one stamp the first counts.

        Args:
            names: joints, any order.
            position: rad.
            stamp_ns: time of the state that the targets answer.
            now_ns: time of the present period.

        Raises:
            BadMessage: see `checked`, and a stamp that is stale or in the future.
        """
        target = checked(names, position)
        if stamp_ns > now_ns:
            raise BadMessage(f"{Topic.LEG_TARGETS} is stamped {stamp_ns / 1e9:.3f} s, but it is {now_ns / 1e9:.3f} s; {_REMEDY}.")
        if now_ns - stamp_ns > self._age_ns:
            raise BadMessage(f"{Topic.LEG_TARGETS} answers a state of {stamp_ns / 1e9:.3f} s, stale at {now_ns / 1e9:.3f} s; {_REMEDY}.")
        if stamp_ns > self._stamp:
            self._stamp, self._target, self._following = stamp_ns, target, True

    def decide(self, now_ns: int) -> tuple[bool, np.ndarray | None]:
        """Whether it is settled what holds in the period that begins now, and the targets (8,) rad, None for none."""
        if self._stamp == now_ns:
            return True, self._target
        if not self._lockstep:
            self._following = self._following and now_ns - self._stamp <= self._age_ns
            return True, self._target if self._following else None
        if self._following:
            if self._asked != now_ns:
                self._asked, self._asked_at = now_ns, self._clock()
            if self._clock() - self._asked_at < self._patience_s:
                return False, None
            self._following = False
        return True, None
