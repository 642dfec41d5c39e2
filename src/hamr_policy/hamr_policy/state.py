"""The robot's state as policies see it: SI, one row a robot, whether it comes from a batch of simulated robots or from topics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from hamr_description.units import length_to_si, quaternion_to_ros, rate_to_si

if TYPE_CHECKING:
    from hamr_dynamics.batch import BatchSim


@dataclass(frozen=True, slots=True)
class State:
    """State of n robots.

    Attributes:
        position: (n, 3) m, origin of base_link in odom.
        quaternion: (n, 4) xyzw.
        velocity: (n, 3) m/s of that origin, in base_link.
        angular_velocity: (n, 3) rad/s, in base_link.
        angles: (n, 8) rad, hip angles in canonical joint order.
        rates: (n, 8) rad/s.
    """

    position: np.ndarray
    quaternion: np.ndarray
    velocity: np.ndarray
    angular_velocity: np.ndarray
    angles: np.ndarray
    rates: np.ndarray

    @classmethod
    def of_batch(cls, sim: BatchSim) -> State:
        """All robots of a BatchSim."""
        quaternion = quaternion_to_ros(sim.quaternion)
        angles, rates = sim.measured()
        return cls(
            position=length_to_si(sim.position),
            quaternion=quaternion,
            velocity=into_base(quaternion, sim.velocity),  # mm/ms are m/s
            angular_velocity=rate_to_si(sim.angular_velocity),
            angles=angles,
            rates=rate_to_si(rates),
        )

    @classmethod
    def of_sample(cls, sample: np.ndarray, base: np.ndarray) -> State:
        """One robot, from the engine's (7, 8) sample and (13,) base (docs/architecture.md)."""
        base = base[None]
        return cls(base[:, :3], base[:, 3:7], base[:, 7:10], base[:, 10:], sample[None, 0], sample[None, 1])


def into_base(quaternion: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """World vectors (n, 3) in base_link, for orientations (n, 4) xyzw."""
    axis, w = quaternion[:, :3], quaternion[:, 3:]
    turn = 2.0 * np.cross(vector, axis)
    return vector + w * turn + np.cross(turn, axis)


def attitude(quaternion: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Roll, pitch, yaw (n,) rad each: fixed axes x, y, z in this order (REP 103), for orientations (n, 4) xyzw."""
    x, y, z, w = quaternion.T
    roll = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0))
    yaw = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return roll, pitch, yaw


def wrap(angle: np.ndarray) -> np.ndarray:
    """Angles in (-pi, pi], rad."""
    return angle - 2.0 * np.pi * np.round(angle / (2.0 * np.pi))
