"""Gymnasium environments of one robot: `gymnasium.make("hamr_policy.env:HamrWalk-v0", backend="full")`, and `HamrTurn-v0`."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar

import gymnasium
import numpy as np

from .backend import simulator
from .episodes import Episodes
from .observation import DEFAULT_VIEW
from .spaces import action_space, observation_space
from .task import task_named


class HamrEnv(gymnasium.Env):
    """One robot, 4 ms a step, episodes of 300 ms.

    Observation: (size,) float32, names and units in `observation.components(view)`. Action: (8,) target hip angles, 1 is 25 degrees.
    Reward: of the task (`task.TASKS`). Terminated when `task.fallen` or `task.too_fast`, truncated after 300 ms.
    `reset(seed=..., options={"command": +1 or -1})` starts near standing (`start.stand_about`); the direction is random unless given.

    Args:
        task: walk or turn.
        backend, residual: see `backend.simulator`.
        view: what is seen of x, y and yaw, key of `observation.VIEWS`.
    """

    metadata: ClassVar[dict] = {"render_modes": []}

    def __init__(self, task: str, *, backend: str = "full", residual: str | Path = "", view: str = DEFAULT_VIEW) -> None:
        self._episodes = Episodes(task_named(task), simulator(backend, 1, residual=residual, dtype=np.float64), view)
        self.observation_space = observation_space(view)
        self.action_space = action_space()

    def reset(self, *, seed: int | None = None, options: dict | None = None) -> tuple[np.ndarray, dict]:
        super().reset(seed=seed)
        self._episodes.rng = self.np_random
        command = (options or {}).get("command")
        self._episodes.begin(command=None if command is None else np.array([float(command)]))
        return self._episodes.observations()[0], {}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict]:
        outcome = self._episodes.step(np.asarray(action)[None])
        seen = self._episodes.observations()[0]
        return seen, float(outcome.reward[0]), bool(outcome.terminated[0]), bool(outcome.truncated[0]), {}


for _id, _task in (("HamrWalk-v0", "walk"), ("HamrTurn-v0", "turn")):
    gymnasium.register(_id, entry_point=HamrEnv, kwargs={"task": _task})
