"""A torque law with its weights: what stands in HAMR-simple in place of the drive."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from .mlp import Mlp
from .series import Series


class Law(Protocol):
    """Architecture of a law (q, v, V) -> hip torque, without weights; equal architectures share one compiled kernel."""

    kind: str

    @property
    def rows(self) -> tuple[str, ...]:
        """Names of the weights, in order."""

    def source(self, robots: int) -> str:
        """Numba source of `network(state, drive, weights, scratch, torque)` for blocks of `robots` robots (hamr_dynamics.driver)."""

    def scratch(self, robots: int) -> int:
        """Scratch numbers that it needs per block."""

    def packed(self, values: np.ndarray) -> np.ndarray:
        """Weights in the order in which the kernel reads them."""


LAWS: dict[str, type] = {law.kind: law for law in (Series, Mlp)}


@dataclass(frozen=True, eq=False, slots=True)
class Network:
    """A law with weights (float64, in the order of `law.rows`), as `hamr_dynamics.plant.Plant.network` takes it."""

    law: Law
    values: np.ndarray

    def source(self, robots: int) -> str:
        """See `Law.source`."""
        return self.law.source(robots)

    def scratch(self, robots: int) -> int:
        """See `Law.scratch`."""
        return self.law.scratch(robots)

    def weights(self, dtype) -> np.ndarray:
        """Weights as the kernel takes them."""
        return self.law.packed(self.values).astype(dtype)
