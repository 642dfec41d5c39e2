"""One robot behind the topics: the `Engine` protocol, and the compiled kernel as an engine."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

import numba
import numpy as np

from hamr_description import units
from hamr_description.names import LEGS, joint_signs
from hamr_description.numbers import value

from .batch import DRIVE_SIGN, SIGN, BatchSim
from .effects.effects_file import EffectsFile
from .plant import Plant

#: Rows of a servo sample, (7, 8) float64 in SI, joints in canonical order.
ROWS = ("position", "velocity", "deflection", "deflection_rate", "torque", "force", "acceleration")
BASE_SIZE = 13  # position m, quaternion xyzw, linear velocity in base_link m/s, angular velocity rad/s


class Engine(Protocol):
    """A simulated robot that takes eight voltages per servo sample.

    Attributes:
        backend: full, simple, simple_published or residual.
        engine: kernel or mujoco.
        environment: ground or suspended.
        effects: what is added to the model; only the kernel takes any.
    """

    backend: str
    engine: str
    environment: str
    effects: EffectsFile

    def reset(self, seed: int = 0) -> None:
        """Back to rest; the same seed gives the same run."""

    def measure(self, sample: np.ndarray) -> None:
        """Fills a servo sample (7, 8), rows `ROWS`: hip angle rad, rad/s; tip m, m/s; torque N m; force N; rad/s^2."""

    def substep(self, volts: np.ndarray) -> None:
        """Holds (8,) V for one servo period."""

    def base(self, out: np.ndarray) -> None:
        """Fills (13,): position m, quaternion xyzw, linear velocity in base_link m/s, angular velocity rad/s."""

    def counters(self) -> dict[str, float]:
        """Totals since reset: stops_hit, constraint_residual (mm), finite (1 or 0)."""


class KernelEngine:
    """The one-robot kernel of a plant (see `Engine`). The seed is unused: the kernel has no randomness of its own."""

    engine = "kernel"

    def __init__(
        self, plant: str | Plant, *, environment: str = "ground", friction: float | None = None, gravity: float | None = None,
        effects: str | Path | EffectsFile | None = None,
    ) -> None:  # fmt: skip
        self.sim = BatchSim(plant, 1, environment=environment, friction=friction, gravity=gravity, block=1, effects=effects)
        self.effects = self.sim.effects
        self.backend, self.environment = self.sim.plant.name, environment
        self._neutral = value("actuator.neutral_voltage")
        self._drive = np.zeros((1, 1, 8))  # rows (swing, lift) x legs
        self._leg_rows = self._drive[0, 0].reshape(2, 4).T  # (4, 2) view: canonical order
        self._sign, self._drive_sign = SIGN.reshape(4, 2), DRIVE_SIGN.reshape(4, 2)
        self._y_sign = np.array([float(joint_signs(leg)[1]) for leg in LEGS])
        self._state = self.sim._state[0].reshape(-1, 4)
        self._no_record = np.empty((1, 0, 24))
        # angles and rates as sensors have them: the first rows of the state, or the last of what is seen
        self._measured = self.sim._seen[0, -16:] if self.sim.plant.effects else self.sim._state[0, :16]

    def reset(self, seed: int = 0) -> None:
        """Stand at rest, stops counted from zero."""
        self.sim.reset()
        self._state[6:8] = 0.0
        self._drive[:] = 0.0

    def measure(self, sample: np.ndarray) -> None:
        """Fills a servo sample; tip forces and torques belong to the voltage that was held last."""
        sim = self.sim
        sim._module.look(sim._state, self._drive[0], sim._param, sim._weights, sim._seen)
        _fill(sample, self._measured, sim._state[0], sim._seen[0], self._sign, self._y_sign)

    def substep(self, volts: np.ndarray) -> None:
        """One compiled step."""
        self._leg_rows[:] = (volts.reshape(4, 2) - self._neutral) * self._drive_sign
        sim = self.sim
        sim._module.advance(
            1, False, sim._state, self._drive, sim._target, sim._param, sim._base, sim._body, sim._weights, self._no_record
        )

    def base(self, out: np.ndarray) -> None:
        """Pose and twist; a suspended chassis does not move."""
        sim = self.sim
        out[0:3] = units.length_to_si(sim.position[0])
        out[3:7] = units.quaternion_to_ros(sim.quaternion[0])
        out[7:10] = rotate_inverse(sim.quaternion[0], sim.velocity[0])
        out[10:13] = units.rate_to_si(sim.angular_velocity[0])

    def counters(self) -> dict[str, float]:
        """Stops hit (joint-substeps); the closed form has no constraint residual."""
        return {"stops_hit": float(self.sim.counts.sum()), "constraint_residual": 0.0, "finite": float(self.sim.finite[0])}


_length, _rate, _torque = (numba.njit(f) for f in (units.length_to_si, units.rate_to_si, units.torque_to_si))


@numba.njit(cache=True)
def _fill(sample, measured, state, seen, sign, y_sign):
    """A servo sample from the one-robot kernel's rows (row r of leg i at 4 r + i)."""
    for leg in range(4):
        for axis in range(2):
            joint = 2 * leg + axis
            s, y = sign[leg, axis], y_sign[leg]
            sample[0, joint] = measured[4 * axis + leg] * s
            sample[1, joint] = _rate(measured[4 * (2 + axis) + leg] * s)
            sample[2, joint] = _length(seen[4 * axis + leg] * y)
            sample[3, joint] = seen[4 * (2 + axis) + leg] * y  # mm/ms equal m/s
            sample[4, joint] = _torque(seen[4 * (6 + axis) + leg] * s)
            sample[5, joint] = seen[4 * (4 + axis) + leg] * y
            sample[6, joint] = _rate(_rate(state[4 * (4 + axis) + leg] * s))


def rotate_inverse(quaternion: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """World vector (3,) in the axes of a frame with orientation wxyz."""
    w, x, y, z = quaternion
    u = np.array([x, y, z])
    return vector - 2 * w * np.cross(u, vector) + 2 * np.cross(u, np.cross(u, vector))
