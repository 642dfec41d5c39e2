"""Checkpoints of a training run, from which it goes on to the bit."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback

from hamr_description.errors import ConfigError

from .vector import HamrVecEnv

EVERY = 50  # updates between checkpoints


class Checkpoint(BaseCallback):
    """Saves the state of learning every EVERY updates, and the learning curve with it.

    At a checkpoint all episodes begin anew and all random numbers are seeded from the run's seed and the number of updates. So network,
    optimiser and count of steps are all that carries over: a resumed run is the uninterrupted one.

    Attributes:
        curve: [steps, mean reward of the episodes that ended since the last update].
    """

    def __init__(self, path: Path, settings: Mapping, env: HamrVecEnv) -> None:
        super().__init__()
        self._path, self._env = path, env
        self._settings = json.loads(json.dumps(settings))
        self.curve: list[list[float]] = []

    def load(self, model: PPO) -> int:
        """Puts a saved state into a fresh model; returns its steps, 0 if nothing is saved. ConfigError if it is of other settings."""
        if not self._path.exists():
            return 0
        saved = torch.load(self._path, weights_only=True)  # tensors and plain values: a file cannot run code
        for name, here in self._settings.items():
            if saved["settings"].get(name) != here:
                raise ConfigError(
                    f"'{self._path}' is of another training ({name}: {saved['settings'].get(name)}, here {here}): choose another folder, "
                    "or do not resume."
                )  # fmt: skip
        model.policy.load_state_dict(saved["policy"])
        model.policy.optimizer.load_state_dict(saved["optimizer"])
        model.num_timesteps = saved["steps"]
        self.curve = saved["curve"]
        return saved["steps"]

    def _save(self) -> None:
        state = {
            "settings": self._settings, "steps": self.model.num_timesteps, "curve": self.curve,
            "policy": self.model.policy.state_dict(), "optimizer": self.model.policy.optimizer.state_dict(),
        }  # fmt: skip
        temporary = self._path.with_suffix(".tmp")
        torch.save(state, temporary)
        os.replace(temporary, self._path)

    def _on_rollout_start(self) -> None:
        self.model.ep_info_buffer.clear()
        updates = self.model.num_timesteps // (self.model.n_steps * self._env.num_envs)
        if updates % EVERY:
            return
        self._save()
        seeds = np.random.SeedSequence([self._settings["seed"], updates]).generate_state(3)
        torch.manual_seed(int(seeds[0]))
        np.random.seed(seeds[1])  # noqa: NPY002 - stable-baselines3 shuffles its batches with it
        self.model._last_obs = self._env.restart(int(seeds[2]))
        self.model._last_episode_starts[:] = True

    def _on_rollout_end(self) -> None:
        ended = [episode["r"] for episode in self.model.ep_info_buffer]
        if ended:
            self.curve.append([self.model.num_timesteps, float(np.mean(ended))])

    def _on_step(self) -> bool:
        return True
