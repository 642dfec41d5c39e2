"""The leg law: target hip angles to drive voltages, at every servo sample. Pure, compiled, allocation-free."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from hamr_description import names, units
from hamr_description.numbers import value

NEUTRAL_VOLT = value("actuator.neutral_voltage")
LOWEST_VOLT = value("actuator.ground_voltage")
HIGHEST_VOLT = value("actuator.bias_voltage")
TORQUE_SIGN = np.array([names.torque_sign(joint) for joint in names.JOINTS], float)
TORQUE_SIGN.setflags(write=False)


@dataclass(frozen=True, slots=True)
class Gains:
    """PD gains of one drive axis pair, outside units.

    Attributes:
        kp: (swing, lift) V/rad.
        kd: (swing, lift) V s/rad.
    """

    kp: tuple[float, float]
    kd: tuple[float, float]

    @classmethod
    def default(cls) -> Gains:
        """The project's gains, tuned for a 10 degree step (`controller` in numbers.yaml)."""
        kp, kd = value("controller.kp"), units.time_to_si(value("controller.kd"))
        return cls((kp, kp), (kd, kd))

    @classmethod
    def lqr(cls) -> Gains:
        """The published LQR gains, for comparison."""
        kp, kd = value("controller.kp_lqr"), units.time_to_si(value("controller.kd_lqr"))
        return cls(tuple(kp.tolist()), tuple(kd.tolist()))

    def per_joint(self) -> tuple[np.ndarray, np.ndarray]:
        """((8,) V/rad, (8,) V s/rad) in canonical joint order, with the sign of hip torque per volt."""
        legs = len(names.LEGS)
        kp, kd = TORQUE_SIGN * np.tile(self.kp, legs), TORQUE_SIGN * np.tile(self.kd, legs)
        kp.setflags(write=False)
        kd.setflags(write=False)
        return kp, kd


@njit(cache=True, nogil=True)
def signed_law(feed, target, position, velocity, kp, kd, out):
    """V = feed + kp (target - position) - kd velocity, clipped; all (8,), kp and kd signed as by `Gains.per_joint`."""
    for j in range(out.size):
        volt = feed[j] + (kp[j] * (target[j] - position[j]) - kd[j] * velocity[j])
        out[j] = min(max(volt, LOWEST_VOLT), HIGHEST_VOLT)


_NEUTRAL = np.full(len(names.JOINTS), NEUTRAL_VOLT)
_NEUTRAL.setflags(write=False)


def voltages(target, position, velocity, gains: Gains, out) -> None:
    """Drive voltages of one servo sample.

    Args:
        target: (8,) rad, canonical joint order.
        position: (8,) rad.
        velocity: (8,) rad/s.
        gains: PD gains.
        out: (8,) V, filled; about the neutral voltage, within the supply.
    """
    signed_law(_NEUTRAL, target, position, velocity, *gains.per_joint(), out)
