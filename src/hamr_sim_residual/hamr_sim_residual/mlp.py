"""The paper's law: a tanh network over (q, v, V), for each leg alone (one network for all legs, by mirror symmetry) or for the whole robot.

    torque = skip . x + b + W ... tanh(W tanh(W x + b) + b),   x = (q, v, V)

in the leg frame. A whole-robot network sees the four legs' rows in the order of the kernel's arrays (quantity, axis, leg), so
its inputs need no gathering. Scaling of inputs and outputs is folded into the weights.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from hamr_dynamics import emit

from . import mlp_kernel

SCOPES = ("leg", "robot")


@dataclass(frozen=True, slots=True)
class Mlp:
    """Architecture of a tanh network.

    Attributes:
        scope: "leg" (6 inputs, 2 torques) or "robot" (24 and 8).
        hidden: sizes of the hidden layers.
    """

    scope: str = "leg"
    hidden: tuple[int, ...] = (100, 100)
    kind = "mlp"

    def __post_init__(self) -> None:
        if self.scope not in SCOPES or not self.hidden or not all(isinstance(n, int) and 0 < n <= 1000 for n in self.hidden):
            raise ValueError(f"a network is for {' or '.join(SCOPES)} and has hidden layers of 1 to 1000, not {self.scope} {self.hidden}")

    @property
    def legs(self) -> int:
        """Legs that one network drives."""
        return 1 if self.scope == "leg" else 4

    @property
    def sizes(self) -> tuple[int, ...]:
        """Of the layers, inputs and outputs included."""
        return (6 * self.legs, *self.hidden, 2 * self.legs)

    def shapes(self) -> Iterator[tuple[str, tuple[int, ...]]]:
        """Names and shapes of the weight arrays, in order."""
        for i, (n_in, n_out) in enumerate(zip(self.sizes, self.sizes[1:], strict=False)):
            yield f"w{i}", (n_out, n_in)
            yield f"b{i}", (n_out,)
        yield "skip", (self.sizes[-1], self.sizes[0])

    @property
    def rows(self) -> tuple[str, ...]:
        """Names of the weights."""
        return emit.rows(**{name: int(np.prod(shape)) for name, shape in self.shapes()})

    def split(self, values: np.ndarray) -> dict[str, np.ndarray]:
        """Weights (W,) -> arrays by name."""
        ends = np.cumsum([np.prod(shape) for _, shape in self.shapes()])
        return {name: part.reshape(shape) for (name, shape), part in zip(self.shapes(), np.split(values, ends[:-1]), strict=True)}

    def join(self, arrays: dict[str, np.ndarray]) -> np.ndarray:
        """Inverse of `split`."""
        return np.concatenate([np.ravel(arrays[name]) for name, _ in self.shapes()])

    def torque(self, x: np.ndarray, values: np.ndarray) -> np.ndarray:
        """(n, outputs) N mm for inputs (n, inputs): the plain form, for tests and plots."""
        arrays, y = self.split(values), x
        for i in range(len(self.hidden)):
            y = np.tanh(y @ arrays[f"w{i}"].T + arrays[f"b{i}"])
        last = len(self.hidden)
        return y @ arrays[f"w{last}"].T + arrays[f"b{last}"] + x @ arrays["skip"].T

    def source(self, robots: int) -> str:
        """Compiled form for blocks of `robots` robots (hamr_dynamics.driver)."""
        return mlp_kernel.source(self.sizes, lanes=4 * robots // self.legs, legs=self.legs)

    def scratch(self, robots: int) -> int:
        """Scratch numbers per block."""
        return mlp_kernel.scratch(self.sizes)

    def packed(self, values: np.ndarray) -> np.ndarray:
        """Weights in the order in which the kernel reads them."""
        return mlp_kernel.pack(self.split(values), len(self.hidden) + 1)
