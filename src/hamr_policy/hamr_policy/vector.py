"""The vectorised environment of stable-baselines3 on BatchSim: one compiled call steps all robots."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from gymnasium import spaces
from stable_baselines3.common.vec_env import VecEnv

from . import observation
from .episodes import Episodes
from .task import EPISODE_STEPS


class HamrVecEnv(VecEnv):
    """Episodes of n robots that begin anew by themselves.

    On a step that ends an episode, the observation returned is the first of the next one; `terminal_observation` and
    `TimeLimit.truncated` (300 ms have passed) stand in its info, and `episode` with the sum of its rewards.
    The first episode of each robot is cut to a random length, so that starts are spread over the steps.
    """

    def __init__(self, episodes: Episodes, *, seed: int = 0, carry_on: float = 0.0, spread: bool = True) -> None:
        self.episodes = episodes
        self._rng = np.random.default_rng(seed)
        self._spread, self._carry_on = spread, carry_on
        self._sums = np.zeros(episodes.n)
        self._actions = np.zeros((episodes.n, 8))
        box = spaces.Box(-np.inf, np.inf, (observation.size(episodes.view),), np.float32)
        super().__init__(episodes.n, box, spaces.Box(-1.0, 1.0, (8,), np.float32))

    def restart(self, seed: int) -> np.ndarray:
        """New episodes everywhere, with random numbers from a seed."""
        self._rng = np.random.default_rng(seed)
        return self.reset()

    def reset(self) -> np.ndarray:
        if self._seeds[0] is not None:
            self._rng = np.random.default_rng(self._seeds[0])
            self._reset_seeds()
        self.episodes.begin(np.ones(self.num_envs, bool), self._rng)
        if self._spread:
            self.episodes.steps[:] = self._rng.integers(0, EPISODE_STEPS, self.num_envs)
        self._sums[:] = 0.0
        return self.episodes.observations()

    def step_async(self, actions: np.ndarray) -> None:
        self._actions = actions

    def step_wait(self):
        outcome = self.episodes.step(self._actions)
        self._sums += outcome.reward
        done = outcome.fallen | outcome.over
        seen = self.episodes.observations()
        infos: list[dict] = [{} for _ in range(self.num_envs)]
        if done.any():
            for i in np.flatnonzero(done):
                length = int(self.episodes.steps[i])
                infos[i] = {
                    "terminal_observation": seen[i],
                    "TimeLimit.truncated": bool(outcome.over[i]),
                    "episode": {"r": float(self._sums[i]), "l": length, "t": 0.0},
                }
            self._sums[done] = 0.0
            self.episodes.begin(done, self._rng, going=outcome.over & (self._rng.random(self.num_envs) < self._carry_on))
            seen = np.where(done[:, None], self.episodes.observations(), seen)
        return seen, outcome.reward.astype(np.float32), done, infos

    def close(self) -> None:
        pass

    def get_attr(self, attr_name: str, indices=None) -> list:
        return [getattr(self, attr_name)] * len(self._chosen(indices))

    def set_attr(self, attr_name: str, value, indices=None) -> None:
        setattr(self, attr_name, value)

    def env_method(self, method_name: str, *args, indices=None, **kwargs) -> list:
        raise NotImplementedError("The robots of a batch have no methods of their own.")

    def env_is_wrapped(self, wrapper_class, indices=None) -> list[bool]:
        return [False] * len(self._chosen(indices))

    def _chosen(self, indices) -> Sequence[int]:
        return range(self.num_envs) if indices is None else self._get_indices(indices)
