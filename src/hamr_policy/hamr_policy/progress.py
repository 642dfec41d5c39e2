"""A progress bar for training, on standard error."""

from __future__ import annotations

from time import monotonic

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback
from tqdm import tqdm


class Progress(BaseCallback):
    """Steps done of `steps`, and the mean reward of the last episodes.

    Attributes:
        seconds: wall time of learning.
    """

    def __init__(self, label: str, steps: int) -> None:
        super().__init__()
        self._label, self._steps, self.seconds = label, steps, 0.0

    def _on_training_start(self) -> None:
        self._bar = tqdm(total=self._steps, initial=self.model.num_timesteps, desc=self._label, unit="step", unit_scale=True, disable=None)
        self._began = monotonic()

    def _on_step(self) -> bool:
        self._bar.update(self.training_env.num_envs)
        return True

    def _on_rollout_end(self) -> None:
        if self.model.ep_info_buffer:
            self._bar.set_postfix(reward=f"{np.mean([episode['r'] for episode in self.model.ep_info_buffer]):.1f}")

    def _on_training_end(self) -> None:
        self.seconds = monotonic() - self._began
        self._bar.close()
