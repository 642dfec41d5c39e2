"""The paper's surrogate f_s: a tanh network that stands in for HAMR-simple's step, so that gradients can pass it.

It maps (q, v, torque) to the acceleration over a 50 us step. The paper leaves its training range open; here it is uniform over
+-0.5 rad (just inside the end stops), +-0.3 rad/ms (what white noise at full drive reaches) and +-0.35 N mm (twice the drive at full
voltage), every variable scaled to [-1, 1]. Front and rear legs differ slightly, so one more input says which it is (leg scope).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch

from hamr_description.names import LEGS
from hamr_description.numbers import value
from hamr_dynamics.leg_step import LegStep

from .perceptron import TYPE, Adam, Perceptron

RANGE = {"angle": 0.5, "rate": 0.3, "torque": 0.35}
SAMPLES, BATCH, UPDATES, RATE = 200_000, 1024, 6000, 1e-2


def accelerations(step: LegStep, q, v, torque, legs) -> np.ndarray:
    """Accelerations (n, 2), rad/ms^2, of steps from q, v (n, 2) under torques (n, 2), leg names (n,)."""
    columns = {leg: step.parameters(leg, gravity=value("robot.gravity")) for leg in LEGS}
    param = np.array([columns[leg] for leg in legs]).T
    state = np.concatenate([q.T, v.T, np.zeros((2, len(q)))])
    for _ in range(2):  # the step predicts its midpoint rates with the last acceleration: here, its own
        state[4:] = step.step(state, torque.T, param)[4:]
    return state[4:].T


@dataclass(frozen=True, slots=True)
class Surrogate:
    """A trained f_s of `legs` legs (1 or 4).

    Attributes:
        error: root mean square of its error on samples it has not seen, relative to the accelerations'.
    """

    net: Perceptron
    layers: list[torch.Tensor]
    legs: int
    scale: float
    error: float

    def __call__(self, q, v, torque, rear) -> torch.Tensor:
        """Accelerations (n, 2 legs); q, v, torque likewise, rear (n, 1) is -1 for front and 1 for rear legs."""
        parts = [q / RANGE["angle"], v / RANGE["rate"], torque / RANGE["torque"]]
        return self.scale * self.net(self.layers, torch.cat(parts + ([rear] if self.legs == 1 else []), dim=1))


def learn(step: LegStep, legs: int, random: np.random.Generator, progress) -> Surrogate:
    """Trains f_s on random states of the step; progress() is called once an update."""
    names = ("fl", "rl") * (SAMPLES // 2) if legs == 1 else LEGS * (SAMPLES // 4)
    unit = random.uniform(-1.0, 1.0, (3, len(names), 2))
    acceleration = accelerations(step, *(x * r for x, r in zip(unit, RANGE.values(), strict=True)), names)
    scale = float(np.abs(acceleration).max())
    inputs = [x.reshape(-1, 2 * legs) for x in unit] + ([np.tile([[-1.0], [1.0]], (SAMPLES // 2, 1))] if legs == 1 else [])
    x = torch.tensor(np.concatenate(inputs, axis=1), dtype=TYPE)
    y = torch.tensor(acceleration.reshape(-1, 2 * legs) / scale, dtype=TYPE)
    held = len(x) // 20
    net = Perceptron((x.shape[1], 100, 100, y.shape[1]))
    adam = Adam(net.initial(random), rate=RATE, updates=UPDATES)
    for _ in range(UPDATES):
        chosen = torch.from_numpy(random.integers(held, len(x), BATCH))
        adam.update(lambda w, i=chosen: 100.0 * torch.mean((net(net.split(w), x[i]) - y[i]) ** 2))
        progress()
    layers = net.split(adam.weights.detach())
    error = float(torch.sqrt(torch.mean((net(layers, x[:held]) - y[:held]) ** 2) / torch.mean(y[:held] ** 2)))
    return Surrogate(net, layers, legs, scale, error)
