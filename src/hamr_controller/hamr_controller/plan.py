"""What a driver does in one target period."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hamr_description.names import JOINTS
from hamr_description.rates import SUBSTEPS

from .law import NEUTRAL_VOLT, Gains, signed_law

JOINT_COUNT = len(JOINTS)
PLAN_FEED = SUBSTEPS * JOINT_COUNT  # numbers of the feed in `Plan.memory`
_NEUTRAL_FEED = np.full((SUBSTEPS, JOINT_COUNT), NEUTRAL_VOLT)
_NONE = np.zeros(JOINT_COUNT)


@dataclass(frozen=True, slots=True)
class Plan:
    """V_k = feed_k + kp (target - position_k) - kd velocity_k, clipped, for the samples k of one period.

    Attributes:
        feed: (80, 8) V.
        target: (8,) rad.
        kp: (8,) V/rad, signed as by `Gains.per_joint`.
        kd: (8,) V s/rad, signed as well.
    """

    feed: np.ndarray
    target: np.ndarray
    kp: np.ndarray
    kd: np.ndarray

    def __post_init__(self) -> None:
        # Compiled code takes writable and read-only arrays for two types, and would be compiled anew amid a run for the other one.
        for name in self.__slots__:
            array = np.ascontiguousarray(getattr(self, name), float).view()
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    @classmethod
    def neutral(cls) -> Plan:
        """The voltage at which the drives are at rest."""
        return cls(_NEUTRAL_FEED, _NONE, _NONE, _NONE)

    @classmethod
    def track(cls, target: np.ndarray, gains: Gains) -> Plan:
        """The leg law towards target hip angles (8,) rad."""
        return cls(_NEUTRAL_FEED, target, *gains.per_joint())

    @classmethod
    def open_loop(cls, volts: np.ndarray) -> Plan:
        """Voltages (80, 8) V as they are."""
        return cls(volts, _NONE, _NONE, _NONE)

    def answer(self, k: int, sample: np.ndarray, volts: np.ndarray) -> None:
        """Fill the voltages (8,) for sample k, rows (., 8) SI."""
        signed_law(self.feed[k], self.target, sample[0], sample[1], self.kp, self.kd, volts)

    @property
    def memory(self) -> np.ndarray:
        """All numbers in one array, feed first, for compiled code."""
        return np.concatenate([self.feed.ravel(), self.target, self.kp, self.kd])
