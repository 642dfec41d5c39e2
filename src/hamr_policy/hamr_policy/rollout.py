"""Policies run on simulated robots, without learning."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .episodes import Episodes
from .runtime import Policy
from .task import PERIOD_S


@dataclass(frozen=True, slots=True)
class RollOut:
    """n roll-outs.

    Attributes:
        reward: (n,) sum, up to a fall.
        figure: (n,) speed or turning rate in the commanded direction, in the unit of the task: motion up to a fall over the whole time.
        upright: (n,) s until a fall, or the whole time.
    """

    reward: np.ndarray
    figure: np.ndarray
    upright: np.ndarray


def roll_out(policy: Policy, episodes: Episodes, command: np.ndarray, seconds: float) -> RollOut:
    """Runs a policy from near standing in directions (n,) for a time, which may be longer than an episode."""
    task, steps = episodes.task, round(seconds / PERIOD_S)
    reward, moved, lasted = np.zeros(episodes.n), np.zeros(episodes.n), np.zeros(episodes.n)
    standing = np.ones(episodes.n, bool)
    episodes.begin(command=command)
    for _ in range(steps):
        outcome = episodes.step_targets(policy.targets(episodes.observations()))
        standing &= ~outcome.fallen
        reward[standing] += outcome.reward[standing]
        moved[standing] += command[standing] * outcome.pace[standing, task.axis]
        lasted += standing
    return RollOut(reward, moved / steps / task.per_unit, lasted * PERIOD_S)
