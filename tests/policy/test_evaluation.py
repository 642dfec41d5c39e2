"""Figures of merit against what the robots did, and the table of an evaluation."""

from __future__ import annotations

import numpy as np
import pytest

from hamr_description.errors import ConfigError
from hamr_policy.backend import simulator
from hamr_policy.episodes import Episodes
from hamr_policy.evaluate import evaluate, references
from hamr_policy.rollout import roll_out
from hamr_policy.state import attitude
from hamr_policy.task import TASKS


class Trot:
    """Open-loop targets; knocks a robot over at a given step."""

    def __init__(self, episodes: Episodes, fall_at: int = -1) -> None:
        self._episodes, self._fall_at, self._step = episodes, fall_at, 0
        self.yaw = []

    def targets(self, observations):
        if self._step == self._fall_at:
            self._episodes.sim.set_state(quaternion=(0.0, 1.0, 0.0, 0.0), mask=np.arange(self._episodes.n) == 0)
        self._step += 1
        self.yaw.append(attitude(self._episodes.state.quaternion)[2])
        return np.random.default_rng(self._step).uniform(-0.4, 0.4, (self._episodes.n, 8))


def episodes(task: str) -> Episodes:
    return Episodes(TASKS[task], simulator("simple", 4, dtype=np.float64), "heading", rng=np.random.default_rng(0))


def test_speed_is_distance_over_time_in_body_lengths():
    walk, command = episodes("walk"), np.array([1.0, -1.0, 1.0, -1.0])
    run = roll_out(Trot(walk), walk, command, 0.6)
    np.testing.assert_allclose(run.figure, command * walk.state.position[:, 0] / 0.6 / 0.045, rtol=1e-9)  # starts are at x = 0
    assert (run.upright == pytest.approx(0.6)) and np.abs(run.figure).max() > 0.1


def test_turning_rate_is_the_angle_turned_over_time_in_degrees():
    turn, command = episodes("turn"), np.array([1.0, -1.0, 1.0, -1.0])
    policy = Trot(turn)
    run = roll_out(policy, turn, command, 0.6)
    yaw = np.unwrap([*policy.yaw, attitude(turn.state.quaternion)[2]], axis=0)
    np.testing.assert_allclose(run.figure, command * np.rad2deg(yaw[-1] - yaw[0]) / 0.6, rtol=1e-9)
    np.testing.assert_allclose(run.reward, 0.5 * command * (yaw[-1] - yaw[0]) * 250, rtol=1e-9)


def test_a_fall_ends_reward_and_motion_of_that_robot_alone():
    walk = episodes("walk")
    whole = roll_out(Trot(walk), walk, np.ones(4), 0.4)
    walk = episodes("walk")
    cut = roll_out(Trot(walk, fall_at=50), walk, np.ones(4), 0.4)
    assert cut.upright.tolist() == pytest.approx([0.2, 0.4, 0.4, 0.4])
    np.testing.assert_array_equal(cut.figure[1:], whole.figure[1:])
    assert cut.figure[0] != whole.figure[0]


def test_the_table_of_an_evaluation(trained, monkeypatch):
    monkeypatch.setattr("hamr_policy.evaluate.ENDURANCE_S", 0.4)
    rows = evaluate([trained / "policy.onnx"] * 2, ["full"], rollouts=2)["rows"]
    found = {(row["direction"], row["run_on"], row["quantity"]): row for row in rows}
    at_home = {(on, quantity) for on in ("simple", "full") for quantity in ("speed", "reward", "upright")}
    assert set(found) == {(direction, *what) for direction in ("forward", "backward") for what in at_home | {("full", "transfer")}}
    for (direction, on, quantity), row in found.items():
        assert row["task"] == "walk" and row["trained_on"] == "simple"
        assert row["n"] == (2 if quantity == "transfer" else 4) and len(row["by_seed"]) == 2
        assert row["by_seed"][0] == row["by_seed"][1] == pytest.approx(row["mean"])  # the same policy twice, the same starts
        if quantity == "transfer":
            assert row["mean"] == pytest.approx(found[direction, on, "reward"]["mean"] / found[direction, "simple", "reward"]["mean"])
    assert found["forward", "full", "speed"]["reference"] == 4.62 and found["backward", "full", "speed"]["reference"] == 3.18


def test_references_are_the_paper_s():
    assert {d: row["mean"] for d, row in references()["turning_rate"].items()} == {"right": 628.26, "left": 536.86}


def test_a_policy_of_another_residual_model_is_refused(tmp_path):
    from test_policy_file import write

    path = write(tmp_path / "p.onnx", backend="residual", residual="0123456789abcdef")
    with pytest.raises(ConfigError, match=r"another residual model \(0123456789abcdef\)"):
        evaluate([path], [])
