"""A small honest plant for tests of everything around the robot: eight damped hips that know nothing of each other, SI."""

from __future__ import annotations

import numpy as np
from numba import njit

from hamr_controller.atomics import monotonic_ns
from hamr_controller.law import NEUTRAL_VOLT, TORQUE_SIGN
from hamr_description.rates import SERVO_HZ, SUBSTEPS, TARGET_HZ

# HAMR-simple's numbers at rest (swing, lift): kg m^2, N m/rad, N m s/rad, N m/V; coupling left out
INERTIA = np.tile([1.035e-9, 1.941e-9], 4)
STIFFNESS = np.tile([5.019e-4, 6.173e-4], 4)
DAMPING = np.tile([3.65e-8, 4.14e-8], 4)
TORQUE_PER_VOLT = TORQUE_SIGN * np.tile([1.528e-6, 1.672e-6], 4)
STEP = 1 / SERVO_HZ


@njit(cache=True)
def _step(state, volts, busy_ns):
    """state: (5, 8) rows position, velocity, torque, acceleration, and the base's x in [4, 0]."""
    until = monotonic_ns() + busy_ns
    for j in range(8):
        state[2, j] = TORQUE_PER_VOLT[j] * (volts[j] - NEUTRAL_VOLT)
        state[3, j] = (state[2, j] - STIFFNESS[j] * state[0, j] - DAMPING[j] * state[1, j]) / INERTIA[j]
        state[1, j] += STEP * state[3, j]
        state[0, j] += STEP * state[1, j]
        state[4, 0] += STEP * 1e-4 * state[1, j]
    while busy_ns and monotonic_ns() < until:
        pass


@njit(cache=True)
def _measure(state, sample):
    for j in range(8):
        sample[0, j], sample[1, j] = state[0, j], state[1, j]
        sample[2, j], sample[3, j] = 1e-3 * state[0, j], 1e-3 * state[1, j]
        sample[4, j], sample[5, j], sample[6, j] = state[2, j], 1e3 * state[2, j], state[3, j]


@njit(cache=True, nogil=True)
def _servo_period(answer, memory, samples, volts, k, state, busy_ns):
    for i in range(k, SUBSTEPS):
        _step(state, volts[i], busy_ns)
        if i + 1 < SUBSTEPS:
            _measure(state, samples[i + 1])
            if not answer(memory, i + 1, samples[i + 1], volts[i + 1]):
                return i + 1
    return SUBSTEPS


class ToyEngine:
    """Implements Engine (docs/architecture.md). The base creeps along with the hips, so that /odom is not constant.

    Args:
        environment: as for any engine.
        busy_us: wall time that a substep takes at least, to stand for real physics in measurements.
        breaks_at: sim time in s since reset at which the state becomes NaN; 0 for never.
    """

    backend, engine = "toy", "toy"

    def __init__(self, environment: str = "ground", busy_us: float = 0.0, breaks_at: float = 0.0):
        self.environment, self._busy_ns = environment, round(busy_us * 1e3)
        self._breaks_at = round(breaks_at * TARGET_HZ)
        self._state = np.zeros((5, 8))
        self.reset()

    def reset(self, seed: int = 0) -> None:
        self._state[:] = 0.0
        self._state[0] = 0.01 * np.random.default_rng(seed).standard_normal(8)
        self._periods = 0

    def measure(self, sample: np.ndarray) -> None:
        _measure(self._state, sample)

    def substep(self, volts: np.ndarray) -> None:
        _step(self._state, volts, self._busy_ns)

    def servo_period(self, answer, memory: np.ndarray, samples: np.ndarray, volts: np.ndarray, k: int) -> int:
        self._periods += k == 0
        if self._breaks_at and self._periods == self._breaks_at:
            self._state[0] = np.nan
        return _servo_period(answer, memory, samples, volts, k, self._state, self._busy_ns)

    def base(self, out: np.ndarray) -> None:
        out[:] = 0.0
        out[0], out[6] = self._state[4, 0], 1.0

    def counters(self) -> dict[str, float]:
        return {"stops_hit": 0.0}
