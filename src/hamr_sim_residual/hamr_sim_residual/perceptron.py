"""A tanh network on one flat vector of weights, and Adam on such vectors: all the state of a training run is a few arrays."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import torch

torch.set_num_threads(1)  # small products: a second thread costs more than it brings
TYPE = torch.float32


class Perceptron:
    """Layers of sizes n0 - n1 - ... - nk with tanh between, as a function of (weights, x).

    Attributes:
        shapes: of each layer's matrix and bias. count: number of weights.
    """

    def __init__(self, sizes: Sequence[int]) -> None:
        self.shapes = [shape for n_in, n_out in zip(sizes, sizes[1:], strict=False) for shape in ((n_out, n_in), (n_out,))]
        self.count = sum(map(math.prod, self.shapes))

    def split(self, weights: torch.Tensor) -> list[torch.Tensor]:
        """Matrix, bias, matrix, bias, ... as views."""
        parts = torch.split(weights, [math.prod(shape) for shape in self.shapes])
        return [part.view(shape) for part, shape in zip(parts, self.shapes, strict=True)]

    def initial(self, random: np.random.Generator) -> torch.Tensor:
        """Random weights of the scale that keeps signals of unit size; no bias; a small last layer."""
        parts = []
        for i, shape in enumerate(self.shapes):
            last = 0.1 if i == len(self.shapes) - 2 else 1.0
            parts.append(random.normal(0.0, last / math.sqrt(shape[1]), shape).ravel() if len(shape) == 2 else np.zeros(shape))
        return torch.tensor(np.concatenate(parts), dtype=TYPE)

    def __call__(self, layers: list[torch.Tensor], x: torch.Tensor) -> torch.Tensor:
        """Outputs (n, nk) of inputs (n, n0); layers from `split`."""
        for i in range(0, len(layers) - 2, 2):
            x = torch.tanh(torch.addmm(layers[i + 1], x, layers[i].t()))
        return torch.addmm(layers[-1], x, layers[-2].t())


class Adam:
    """Adam with a cosine schedule from `rate` to `rate` / 100, on one vector.

    `arrays` is all it needs to go on to the bit.
    """

    def __init__(
        self, weights: torch.Tensor, *, rate: float, updates: int, done: int = 0, moments: Sequence[torch.Tensor] | None = None
    ) -> None:  # fmt: skip
        self.weights = weights.detach().clone().requires_grad_()
        self.first, self.second = moments or (torch.zeros_like(weights), torch.zeros_like(weights))
        self.rate, self.updates, self.done = rate, updates, done

    def update(self, loss: Callable[[torch.Tensor], torch.Tensor]) -> float:
        """One update; the loss before it. The gradient is clipped to unit length, so that a wild roll-out cannot throw the weights far."""
        value = loss(self.weights)
        (gradient,) = torch.autograd.grad(value, self.weights)
        self.done += 1
        with torch.no_grad():
            gradient = gradient / max(1.0, gradient.norm().item())
            self.first = 0.9 * self.first + 0.1 * gradient
            self.second = 0.999 * self.second + 0.001 * gradient**2
            mean, square = self.first / (1 - 0.9**self.done), self.second / (1 - 0.999**self.done)
            rate = self.rate * (0.01 + 0.99 * 0.5 * (1 + math.cos(math.pi * self.done / self.updates)))
            self.weights -= rate * mean / (square.sqrt() + 1e-8)
        return value.item()

    @classmethod
    def of(cls, arrays, *, rate: float, updates: int) -> Adam:
        """From a checkpoint."""
        weights, first, second = (torch.from_numpy(arrays[name]) for name in ("weights", "first", "second"))
        return cls(weights, rate=rate, updates=updates, done=int(arrays["done"]), moments=(first, second))

    @property
    def arrays(self) -> dict[str, np.ndarray]:
        """For a checkpoint."""
        tensors = {"weights": self.weights.detach(), "first": self.first, "second": self.second}
        return {name: x.numpy() for name, x in tensors.items()} | {"done": np.array(self.done)}
