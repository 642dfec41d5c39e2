"""The vectorised environment of stable-baselines3 on BatchSim: one compiled call steps all robots."""

from __future__ import annotations

import numpy as np
from stable_baselines3.common.vec_env import VecEnv

from .episodes import Episodes
from .spaces import action_space, observation_space
from .task import EPISODE_STEPS


class HamrVecEnv(VecEnv):
    """Episodes that begin anew by themselves.

    On a step that ends an episode, the observation returned is the first of the next one; the info holds `terminal_observation`,
    `TimeLimit.truncated` (300 ms have passed) and `episode` with its sum of rewards `r` and steps `l`.

    Args:
        going: share of the episodes after a truncated one that go on from its last state (`Episodes.begin`), so that a policy learns
            to keep going and to change direction; the others start near standing.
    """

    render_mode = None

    def __init__(self, episodes: Episodes, *, going: float = 0.0) -> None:
        self.episodes = episodes
        self._going = going
        self._sums = np.zeros(episodes.n)
        self._actions = np.zeros((episodes.n, 8), np.float32)
        super().__init__(episodes.n, observation_space(episodes.view), action_space())

    def restart(self, seed: int) -> np.ndarray:
        """New episodes everywhere, with random numbers from a seed; the first ones have random lengths, which spreads later starts."""
        self.episodes.rng = np.random.default_rng(seed)
        self.episodes.begin()
        self.episodes.steps[:] = self.episodes.rng.integers(0, EPISODE_STEPS, self.num_envs)
        self._sums[:] = 0.0
        return self.episodes.observations()

    def reset(self) -> np.ndarray:
        if self._seeds[0] is not None:
            self.episodes.rng = np.random.default_rng(self._seeds[0])
            self._reset_seeds()
        self.episodes.begin()
        self._sums[:] = 0.0
        return self.episodes.observations()

    def step_async(self, actions: np.ndarray) -> None:
        self._actions = actions

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict]]:
        outcome = self.episodes.step(self._actions)
        self._sums += outcome.reward
        seen, done = self.episodes.observations(), outcome.terminated | outcome.truncated
        infos: list[dict] = [{} for _ in range(self.num_envs)]
        for i in np.flatnonzero(done):
            episode = {"r": float(self._sums[i]), "l": int(self.episodes.steps[i]), "t": 0.0}
            infos[i] = {"terminal_observation": seen[i], "TimeLimit.truncated": bool(outcome.truncated[i]), "episode": episode}
        if done.any():
            self._sums[done] = 0.0
            going = outcome.truncated & (self.episodes.rng.random(self.num_envs) < self._going)
            self.episodes.begin(done, going=going)
            seen = np.where(done[:, None], self.episodes.observations(), seen)
        return seen, outcome.reward.astype(np.float32), done, infos

    def close(self) -> None:
        pass

    def get_attr(self, attr_name: str, indices=None) -> list:
        return [getattr(self, attr_name)] * len(list(self._get_indices(indices)))

    def set_attr(self, attr_name: str, value, indices=None) -> None:
        setattr(self, attr_name, value)

    def env_method(self, method_name: str, *args, indices=None, **kwargs) -> list:
        raise NotImplementedError("The robots of a batch have no methods of their own.")

    def env_is_wrapped(self, wrapper_class, indices=None) -> list[bool]:
        return [False] * len(list(self._get_indices(indices)))
