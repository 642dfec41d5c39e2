"""The paper's surrogate f_s: a tanh network that stands in for HAMR-simple's step, so that gradients can pass it.

It maps (q, v, torque) to the acceleration over a 50 us step. The paper leaves its training data open beyond "normally
distributed and scaled to fit [-1, 1]". Here q, v and the acceleration are normal with the SPREAD below, about half as much
again as white noise at full drive shows, q kept inside the stops; the torque is what inverse dynamics gives for them.
Independent torques would do worse: most of a torque goes into the spring, so nearly all samples would lie at accelerations
that no run shows (measured after one-step training, position at 8 ms: 16 times better than HAMR-simple, against 131).
Front and rear legs differ slightly, so one more input says which it is (leg scope).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch

from hamr_description.names import LEGS

from . import inverse
from .perceptron import TYPE, Adam, Perceptron
from .simple import simple_parameters

SPREAD = {"angle": 0.25, "rate": 0.06, "acceleration": 0.04}  # rad, rad/ms, rad/ms^2
LIMIT = 0.5  # rad: just inside the end stops
SCALE = {"angle": 0.5, "rate": 0.25, "torque": 0.5}  # of the inputs
SAMPLES, BATCH, UPDATES, RATE = 200_000, 1024, 6000, 1e-2


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
        parts = [x / s for x, s in zip((q, v, torque), SCALE.values(), strict=True)]
        return self.scale * self.net(self.layers, torch.cat(parts + ([rear] if self.legs == 1 else []), dim=1))


def learn(legs: int, random: np.random.Generator, progress) -> Surrogate:
    """Trains f_s on random states of HAMR-simple's step; progress() is called once an update."""
    parameters = [simple_parameters(leg) for leg in (("fl", "rl") if legs == 1 else LEGS)]
    shape = (SAMPLES // len(parameters), len(parameters), 2)
    q, v, a = (spread * random.standard_normal(shape) for spread in SPREAD.values())
    q = np.clip(q, -LIMIT, LIMIT)
    torque = np.stack([inverse.torque(*(x[:, i] for x in (q, v, a, a)), p) for i, p in enumerate(parameters)], axis=1)
    acceleration, scale = a, float(np.abs(a).max())
    inputs = [x.reshape(-1, 2 * legs) / s for x, s in zip((q, v, torque), SCALE.values(), strict=True)]
    if legs == 1:
        inputs.append(np.tile([[-1.0], [1.0]], (len(q), 1)))
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
