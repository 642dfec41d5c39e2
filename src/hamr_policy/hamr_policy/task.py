"""The two primitives: what is rewarded, and when an episode ends (SEED, "Learning Primitives")."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hamr_description.errors import ConfigError
from hamr_description.names import LEGS
from hamr_description.numbers import value
from hamr_description.posture import neutral_foot, stand_height
from hamr_description.rates import TARGET_HZ
from hamr_description.units import length_to_si

from .state import State, attitude

PERIOD_S = 1.0 / TARGET_HZ
EPISODE_S = 0.3
EPISODE_STEPS = round(EPISODE_S * TARGET_HZ)
TARGET_LIMIT = value("controller.target_limit")  # rad, the target hip angle of an action of 1

#: A robot beyond these has fallen: it lies on its side, its chassis touches the ground (which the contact model does not know), it has
#: left the ground for good, or a leg has gone through its stops (near 0.5 rad).
TILT_LIMIT = 1.0  # rad
HEIGHT_LIMITS = (length_to_si(-value("robot.chassis_z_range")[0]), length_to_si(3 * stand_height()))  # m
HIP_LIMIT = 1.0  # rad

#: Speeds up to which simulation is believed; the rewards alone drive robots far beyond. No HAMR has run faster than 0.45 m/s (ICRA17), and
#: from about 0.7 m/s the kernels and MuJoCo, whose contacts are regularised differently, no longer agree (docs/policies.md).
SPEED_LIMIT = 0.5  # m/s
TURN_LIMIT = SPEED_LIMIT / length_to_si(float(np.hypot(*neutral_foot(LEGS[0])[:2])))  # rad/s, at which the feet pass at this speed


def tilt(state: State) -> np.ndarray:
    """(n,) rad: sqrt(roll^2 + pitch^2)."""
    roll, pitch, _ = attitude(state.quaternion)
    return np.hypot(roll, pitch)


def fallen(state: State) -> np.ndarray:
    """(n,) whether a robot has fallen, or its state is not finite."""
    low, high = HEIGHT_LIMITS
    height = state.position[:, 2]
    upright = (tilt(state) < TILT_LIMIT) & (height > low) & (height < high) & (np.abs(state.angles).max(axis=1) < HIP_LIMIT)
    return ~(upright & np.isfinite(state.rates.sum(axis=1) + state.velocity.sum(axis=1) + state.angular_velocity.sum(axis=1)))


def too_fast(pace: np.ndarray) -> np.ndarray:
    """(n,) whether robots move over ground, or turn, faster than is believed; pace (n, 3) as `Task.reward` gets it."""
    return (np.hypot(pace[:, 0], pace[:, 1]) > SPEED_LIMIT) | (np.abs(pace[:, 2]) > TURN_LIMIT)


@dataclass(frozen=True, slots=True)
class Task:
    """A primitive.

    Attributes:
        name: as on the command line.
        directions: what the commands +1 and -1 are called.
        axis: of the motion that counts: 0 for x, 2 for yaw.
        reward: (command (n,), pace (n, 3), state after the period) -> (n,); pace is the motion over one period, divided by it: x and y
            in m/s along the heading at the start of the primitive, yaw in rad/s. A mean over the period cannot be
            gamed by swinging in step with the 250 Hz samples, as an instantaneous rate could.
        quantity, unit: of the figure of merit. per_unit: that unit in m/s or rad/s.
    """

    name: str
    directions: dict[int, str]
    axis: int
    reward: Callable[[np.ndarray, np.ndarray, State], np.ndarray]
    quantity: str
    unit: str
    per_unit: float


def walk_reward(command: np.ndarray, pace: np.ndarray, state: State) -> np.ndarray:
    """2 p_d xdot - sqrt(roll^2 + pitch^2), m/s (equal to mm/ms) and rad (SEED, eq. of r_walking)."""
    return 2.0 * command * pace[:, 0] - tilt(state)


def turn_reward(command: np.ndarray, pace: np.ndarray, state: State) -> np.ndarray:
    """0.5 p_d yawrate, rad/s (SEED, eq. of r_turning)."""
    return 0.5 * command * pace[:, 2]


TASKS = {
    task.name: task
    for task in (
        Task("walk", {1: "forward", -1: "backward"}, 0, walk_reward, "speed", "BL/s", length_to_si(value("robot.body_length"))),
        Task("turn", {1: "left", -1: "right"}, 2, turn_reward, "turning_rate", "deg/s", float(np.deg2rad(1.0))),
    )
}


def task_named(name: str) -> Task:
    """The task of a name; ConfigError lists the known ones."""
    if name not in TASKS:
        raise ConfigError(f"Unknown task '{name}': known are {', '.join(TASKS)}.")
    return TASKS[name]
