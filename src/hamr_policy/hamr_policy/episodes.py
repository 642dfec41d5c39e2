"""Many robots in episodes of one task: the environment behind the Gymnasium, the vectorised and the evaluation loops."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hamr_description.numbers import value
from hamr_dynamics.batch import BatchSim

from .observation import observe, place, relative
from .start import place_robots
from .state import State, wrap
from .task import EPISODE_STEPS, PERIOD_S, Task, fallen

TARGET_LIMIT = value("controller.target_limit")  # rad, the target of an action of 1


@dataclass(frozen=True, slots=True)
class Outcome:
    """What one period brought to n robots.

    Attributes:
        reward: (n,).
        pace: (n, 3), as `Task.reward` gets it.
        fallen: (n,) the state left its limits. over: (n,) 300 ms have passed.
    """

    reward: np.ndarray
    pace: np.ndarray
    fallen: np.ndarray
    over: np.ndarray


class Episodes:
    """Robots of a BatchSim, each in its own episode.

    Attributes:
        command: (n,) +1 or -1. steps: (n,) periods since the start of the episode.
    """

    def __init__(self, task: Task, sim: BatchSim, view: str) -> None:
        self.task, self.sim, self.view, self.n = task, sim, view, sim.n
        self.command = np.ones(self.n)
        self.steps = np.zeros(self.n, int)
        self._start = np.zeros((self.n, 3))
        self._look()

    def begin(self, mask: np.ndarray, rng: np.random.Generator, *, going: np.ndarray | None = None, command: np.ndarray | None = None) -> None:
        """New episodes for the robots of an (n,) mask.

        Args:
            rng: draws the states near standing, and the directions.
            going: (n,) robots that start where and as they are instead.
            command: (n,) directions instead of random ones.
        """
        place_robots(self.sim, mask if going is None else mask & ~going, rng)
        self.command[mask] = rng.choice((-1.0, 1.0), mask.sum()) if command is None else command[mask]
        self.steps[mask] = 0
        self._look()
        self._start[mask] = self._here[mask]

    def _look(self) -> None:
        self.state = State.of_batch(self.sim)
        self._here = place(self.state)

    def observations(self) -> np.ndarray:
        """(n, size) float32."""
        return observe(self.view, self.state, self.command, self._start)

    def step(self, actions: np.ndarray) -> Outcome:
        """One period with actions (n, 8) in [-1, 1]; outside they are clipped."""
        before = self._here
        self.sim.step_targets(np.clip(actions, -1.0, 1.0) * TARGET_LIMIT)
        self.steps += 1
        self._look()
        moved = relative(self._here, self._start) - relative(before, self._start)
        moved[:, 2] = wrap(moved[:, 2])
        pace = moved / PERIOD_S
        over = self.steps >= EPISODE_STEPS
        lost = fallen(self.state)
        reward = self.task.reward(self.command, pace, self.state)
        return Outcome(np.where(np.isfinite(reward), reward, 0.0), pace, lost, over & ~lost)
