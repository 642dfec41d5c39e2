"""Many robots in episodes of one task: what the Gymnasium, the vectorised and the evaluation loops have in common."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hamr_dynamics.batch import BatchSim

from .disturbance import Disturbance
from .observation import observe, place, relative
from .start import stand_about
from .state import State, wrap
from .task import EPISODE_STEPS, PERIOD_S, TARGET_LIMIT, Task, fallen, too_fast

SAME = 0.8  # share of the robots that go on with the same primitive, of those that go on


@dataclass(frozen=True, slots=True)
class Outcome:
    """What one period brought to n robots.

    Attributes:
        reward: (n,); 0 where the state is not finite.
        pace: (n, 3), as `Task.reward` gets it.
        fallen: (n,) see `task.fallen`.
        terminated: (n,) fallen, or `task.too_fast`. truncated: (n,) 300 ms have passed, and not terminated.
    """

    reward: np.ndarray
    pace: np.ndarray
    fallen: np.ndarray
    terminated: np.ndarray
    truncated: np.ndarray


class Episodes:
    """Robots of a BatchSim, each in its own episode.

    Args:
        view: what policies see, key of `observation.VIEWS`.
        rng: draws states near standing, directions and disturbances.

    Attributes:
        state: of all robots. command: (n,) +1 or -1. steps: (n,) periods since the start of the episode.
    """

    def __init__(
        self, task: Task, sim: BatchSim, view: str, *, rng: np.random.Generator | None = None, disturbance: Disturbance | None = None
    ) -> None:  # fmt: skip
        self.task, self.sim, self.view, self.n = task, sim, view, sim.n
        self.rng = rng or np.random.default_rng(0)
        self._disturbance = disturbance
        self.command = np.ones(self.n)
        self.steps = np.zeros(self.n, int)
        self._start = np.zeros((self.n, 3))
        self._look()

    def begin(self, mask: np.ndarray | None = None, *, going: np.ndarray | None = None, command: np.ndarray | None = None) -> None:
        """New episodes for all robots, or those of an (n,) mask.

        Args:
            going: (n,) robots that go on from their state: most with the primitive that they are in, the others with a new one.
            command: (n,) directions; random if not given.
        """
        mask = np.ones(self.n, bool) if mask is None else mask
        going = np.zeros(self.n, bool) if going is None else going
        stand_about(self.sim, mask & ~going, self.rng)
        if self._disturbance:
            self._disturbance.begin(mask, self.rng)
        self.steps[mask] = 0
        self._look()
        new = mask & ~(going & (self.rng.random(self.n) < SAME))
        self.command[new] = (self.rng.choice((-1.0, 1.0), self.n) if command is None else command)[new]
        self._start[new] = self._here[new]

    def _look(self) -> None:
        self.state = State.of_batch(self.sim)
        self._here = place(self.state)

    def observations(self) -> np.ndarray:
        """(n, size) float32, see `observation.components`."""
        return observe(self.view, self.state, self.command, self._start)

    def step(self, actions: np.ndarray) -> Outcome:
        """One period with actions (n, 8) in [-1, 1] of the target range; beyond it they are clipped."""
        return self.step_targets(np.clip(actions, -1.0, 1.0) * TARGET_LIMIT)

    def step_targets(self, targets: np.ndarray) -> Outcome:
        """One period towards hip angles (n, 8) rad."""
        before = self._here
        self.sim.step_targets(self._disturbance.targets(targets, self.rng) if self._disturbance else targets)
        self.steps += 1
        self._look()
        pace = (relative(self._here, self._start) - relative(before, self._start)) / PERIOD_S
        pace[:, 2] = wrap(pace[:, 2] * PERIOD_S) / PERIOD_S
        reward = self.task.reward(self.command, pace, self.state)
        down = fallen(self.state)
        terminated = down | too_fast(pace)
        return Outcome(np.where(np.isfinite(reward), reward, 0.0), pace, down, terminated, (self.steps >= EPISODE_STEPS) & ~terminated)
