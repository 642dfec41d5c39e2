"""Rewards against the paper's formulas on states whose answer is known by hand, and the limits of a state."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hamr_policy.state import State
from hamr_policy.task import EPISODE_STEPS, SPEED_LIMIT, TASKS, TURN_LIMIT, fallen, too_fast


def state(*, roll=0.0, pitch=0.0, yaw=0.0, height=0.0127, angles=0.0, rates=0.0) -> State:
    turn = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_quat()[None]
    zero = np.zeros((1, 3))
    return State(np.array([[0.0, 0.0, height]]), turn, zero, zero, np.full((1, 8), angles), np.full((1, 8), rates))


@pytest.mark.parametrize("direction", (1, -1))
def test_walking_pays_twice_the_speed_less_the_tilt(direction):
    pace = np.array([[0.2, 0.5, 7.0]])
    reward = TASKS["walk"].reward(np.array([direction]), pace, state(roll=0.03, pitch=-0.04, yaw=2.0))
    assert reward[0] == pytest.approx(2 * direction * 0.2 - 0.05)


@pytest.mark.parametrize("direction", (1, -1))
def test_turning_pays_half_the_yaw_rate(direction):
    pace = np.array([[0.2, 0.5, 7.0]])
    assert TASKS["turn"].reward(np.array([direction]), pace, state(roll=0.5))[0] == pytest.approx(direction * 3.5)


def test_an_episode_lasts_300_ms():
    assert EPISODE_STEPS == 75


@pytest.mark.parametrize(
    "bad", [{"roll": 1.1}, {"pitch": -1.1}, {"height": 0.005}, {"height": 0.1}, {"angles": 1.2}, {"rates": np.nan}, {"height": np.nan}]
)
def test_states_beyond_the_limits_are_falls(bad):
    assert not fallen(state())[0]
    assert fallen(state(**bad))[0]


def test_speeds_that_no_robot_has_shown_are_too_fast():
    assert pytest.approx(SPEED_LIMIT / np.hypot(12.7547e-3, 17.37e-3), rel=1e-3) == TURN_LIMIT  # feet at rest
    pace = [(0.31, -0.4, 0.0), (0.3, 0.39, 0.0), (0.0, 0.0, -1.01 * TURN_LIMIT), (0.0, 0.0, 0.99 * TURN_LIMIT)]
    assert too_fast(np.array(pace)).tolist() == [True, False, True, False]
