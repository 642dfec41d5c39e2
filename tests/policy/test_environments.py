"""The environments against the checkers of gymnasium and stable-baselines3, and what happens at the ends of episodes."""

from __future__ import annotations

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from stable_baselines3.common import env_checker

import hamr_policy.env  # noqa: F401 - registers the environments
from hamr_description.errors import ConfigError
from hamr_policy.backend import simulator
from hamr_policy.episodes import Episodes
from hamr_policy.start import DROP, feet, stand_about
from hamr_policy.state import State, attitude, into_base
from hamr_policy.task import EPISODE_STEPS, PERIOD_S, TARGET_LIMIT, TASKS
from hamr_policy.vector import HamrVecEnv

IDS = ("HamrWalk-v0", "HamrTurn-v0")


@pytest.mark.parametrize("name", IDS)
@pytest.mark.filterwarnings("error", "ignore:.*infinity. This is probably:UserWarning")  # speeds have no bounds
def test_checkers_pass(name):
    env = gymnasium.make(name, backend="simple")
    check_env(env.unwrapped, skip_render_check=True)
    env_checker.check_env(env.unwrapped, warn=False)


def test_equal_seeds_give_equal_episodes_and_others_do_not():
    env = gymnasium.make("HamrWalk-v0", backend="simple")

    def run(seed):
        first, _ = env.reset(seed=seed)
        return [first, *(env.step(np.full(8, 0.1 * (-1) ** k, np.float32))[0] for k in range(5))]

    assert np.array_equal(run(1), run(1))
    assert not np.array_equal(run(1)[0], run(2)[0])


def test_an_episode_is_truncated_after_300_ms_and_its_direction_can_be_chosen():
    env = gymnasium.make("HamrTurn-v0", backend="simple")
    for command in (1, -1):
        seen, _ = env.reset(seed=0, options={"command": command})
        assert command in seen  # the one value that is exactly +-1
        ends = [env.step(np.zeros(8, np.float32))[2:4] for _ in range(EPISODE_STEPS)]
        assert ends == [(False, False)] * (EPISODE_STEPS - 1) + [(False, True)]


def test_rewards_of_an_episode_add_up_to_the_distance():
    episodes = Episodes(TASKS["walk"], simulator("simple", 8, dtype=np.float64), "place", rng=np.random.default_rng(0))
    episodes.begin()
    x0, total = episodes.state.position[:, 0], np.zeros(8)
    rng = np.random.default_rng(1)
    for _ in range(20):
        outcome = episodes.step(rng.uniform(-1, 1, (8, 8)))
        roll, pitch, _ = attitude(episodes.state.quaternion)
        total += outcome.reward + np.sqrt(roll**2 + pitch**2)
    assert np.abs(episodes.state.position[:, 0] - x0).max() > 1e-4
    np.testing.assert_allclose(total, 2 * episodes.command * (episodes.state.position[:, 0] - x0) / PERIOD_S, atol=1e-6)


def test_more_than_half_a_turn_is_counted_whole():
    """A spinning robot in the air: the yaw rates of the periods add up beyond pi."""
    episodes = Episodes(TASKS["turn"], simulator("simple", 1, dtype=np.float64), "nowhere")
    episodes.begin(command=np.ones(1))
    episodes.sim.set_state(position=(0, 0, 400.0), angular_velocity=(0, 0, 0.06), velocity=0.0)
    episodes._look()
    yaw, turned = [attitude(episodes.state.quaternion)[2][0]], 0.0
    for _ in range(EPISODE_STEPS):
        turned += episodes.step(np.zeros((1, 8))).pace[0, 2] * PERIOD_S
        yaw.append(attitude(episodes.state.quaternion)[2][0])
    assert turned > 4 * np.pi
    assert turned == pytest.approx(np.unwrap(yaw)[-1] - yaw[0], rel=1e-9)


def test_actions_are_targets_in_units_of_25_degrees(monkeypatch):
    episodes = Episodes(TASKS["walk"], simulator("simple", 2), "nowhere")
    seen = []
    monkeypatch.setattr(episodes.sim, "step_targets", seen.append)
    episodes.step(np.array([[1.0] * 8, [-0.5] * 7 + [-3.0]]))
    assert pytest.approx(np.deg2rad(25)) == TARGET_LIMIT
    np.testing.assert_allclose(np.rad2deg(seen[0]), [[25.0] * 8, [-12.5] * 7 + [-25.0]])


def test_starts_differ_and_touch_the_ground_from_above():
    sim = simulator("full", 64, dtype=np.float64)
    stand_about(sim, np.ones(64, bool), np.random.default_rng(0))
    state = State.of_batch(sim)
    up = into_base(state.quaternion, np.tile([0.0, 0.0, 1.0], (64, 1)))
    lowest = np.einsum("nfj,nj->nf", feet(state.angles), up).min(axis=1) + 1e3 * state.position[:, 2]
    assert lowest.min() >= -1e-9 and lowest.max() <= DROP + 1e-9
    assert len(np.unique(state.angles)) == 64 * 8
    sim.step_targets(np.zeros((64, 8)))
    assert sim.finite.all() and np.abs(sim.velocity).max() < 0.3  # nobody is thrown up by a foot in the ground


class Tripped(HamrVecEnv):
    """Two robots, the second of which falls on the third step."""

    def step_wait(self):
        if self.episodes.steps.tolist() == [2, 2]:
            self.episodes.sim.set_state(quaternion=(0.0, 1.0, 0.0, 0.0), mask=np.array([False, True]))
        return super().step_wait()


def test_episodes_end_and_begin_anew_by_themselves():
    env = Tripped(Episodes(TASKS["walk"], simulator("simple", 2), "nowhere", rng=np.random.default_rng(0)))
    env.seed(0)
    first = env.reset()
    rewards = np.zeros(2)
    for step in range(1, EPISODE_STEPS + 1):
        seen, reward, done, infos = env.step(np.zeros((2, 8), np.float32))
        rewards += reward
        if step == 3:
            assert done.tolist() == [False, True] and infos[0] == {}
            assert infos[1]["TimeLimit.truncated"] is False and infos[1]["episode"]["l"] == 3
            assert infos[1]["episode"]["r"] == pytest.approx(rewards[1], rel=1e-5)
            assert abs(infos[1]["terminal_observation"][1]) > 1.0  # upside down
            assert abs(seen[1, 1]) < 0.2  # on its feet again
            assert env.episodes.steps.tolist() == [3, 0]
    assert done.tolist() == [True, False] and infos[0]["TimeLimit.truncated"] is True and infos[0]["episode"]["l"] == EPISODE_STEPS
    assert not np.array_equal(seen[0], infos[0]["terminal_observation"]) and not np.array_equal(seen[0], first[0])


def test_some_episodes_go_on_where_the_last_one_ended():
    env = HamrVecEnv(Episodes(TASKS["walk"], simulator("simple", 64), "nowhere"), going=0.5)
    env.seed(1)
    env.reset()
    for _ in range(EPISODE_STEPS):
        seen, _, done, infos = env.step(np.ones((64, 8), np.float32))
    assert done.all()
    last = np.array([info["terminal_observation"] for info in infos])
    went_on = (seen[:, :-1] == last[:, :-1]).all(axis=1)
    assert 16 < went_on.sum() < 48
    same = (seen[:, -1] == last[:, -1])[went_on]
    assert 0.6 < same.mean() <= 1.0  # most keep their direction


def test_equal_seeds_give_equal_batches():
    def run(seed):
        env = HamrVecEnv(Episodes(TASKS["turn"], simulator("simple", 32), "heading"), going=0.5)
        return [env.restart(seed), *(env.step(np.full((32, 8), 0.3, np.float32))[0] for _ in range(10))]

    assert np.array_equal(run(5), run(5))
    assert not np.array_equal(run(5), run(6))


def test_unknown_backends_and_stray_residual_models_are_named():
    with pytest.raises(ConfigError, match="'fool'"):
        simulator("fool", 1)
    with pytest.raises(ConfigError, match=r"'full' takes no residual model file.*'x.json'"):
        simulator("full", 1, residual="x.json")
