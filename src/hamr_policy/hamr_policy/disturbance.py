"""The paper's two cheap ways to robust policies, for comparison: noise on the torques, and randomised dynamics."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from hamr_description.errors import ConfigError
from hamr_description.numbers import value
from hamr_dynamics.batch import BatchSim


class Disturbance(Protocol):
    """What training adds to a simulator."""

    def begin(self, mask: np.ndarray, rng: np.random.Generator) -> None:
        """Episodes begin for the robots of an (n,) mask."""

    def targets(self, targets: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Targets (n, 8) rad as the leg law gets them."""


class TorqueNoise:
    """Gaussian noise on the hip torques that the leg law asks for (SEED, "Noisy Inputs").

    The paper gives a standard deviation of 0.01 without unit or rate. Here it is 0.01 N mm (6 % of the greatest hip torque) held
    for a control period, as the shift of the target that asks for this torque; voltages saturate as ever.
    """

    STD = 0.01  # N mm

    def __init__(self, sim: BatchSim) -> None:
        per_volt = np.stack([sim.parameter(f"torque_per_volt.{axis}") for axis in (0, 1)], axis=-1)  # (n, 4, 2) N mm/V
        self._std = self.STD / (value("controller.kp") * per_volt.reshape(sim.n, 8))  # rad

    def begin(self, mask: np.ndarray, rng: np.random.Generator) -> None:
        pass

    def targets(self, targets: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        return targets + rng.normal(0.0, self._std)


class DomainRandomisation:
    """Each leg's inertia tensor and stiffness, entry by entry, times a Gaussian of mean 1, drawn anew for every episode.

    Standard deviation 0.2, clipped to 0.7 .. 1.3; tensors that no body can have are drawn again (SEED, "Domain Randomization").
    """

    STD, LOW, HIGH = 0.2, 0.7, 1.3
    NAMES = (*(f"inertia.{i}" for i in range(6)), "stiffness.0", "stiffness.1")

    def __init__(self, sim: BatchSim) -> None:
        self._sim = sim
        self._nominal = np.stack([sim.parameter(name) for name in self.NAMES], axis=-1)  # (n, 4, 8)
        self._present = self._nominal.copy()

    def begin(self, mask: np.ndarray, rng: np.random.Generator) -> None:
        self._present[mask] = self._draw(self._nominal[mask], rng)
        for i, name in enumerate(self.NAMES):
            self._sim.set_parameter(name, self._present[..., i])

    def targets(self, targets: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        return targets

    def _draw(self, nominal: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        drawn = np.empty_like(nominal)
        wanted = np.ones(nominal.shape[:-1], bool)
        while wanted.any():
            drawn[wanted] = nominal[wanted] * np.clip(rng.normal(1.0, self.STD, nominal[wanted].shape), self.LOW, self.HIGH)
            wanted = ~physical(drawn[..., :6])
        return drawn


def physical(inertia: np.ndarray) -> np.ndarray:
    """Whether tensors (..., 6) [ixx, iyy, izz, ixy, ixz, iyz] are positive definite and obey the triangle inequality."""
    moments = np.linalg.eigvalsh(inertia[..., [[0, 3, 4], [3, 1, 5], [4, 5, 2]]])
    return (moments[..., 0] > 0) & (moments[..., 0] + moments[..., 1] >= moments[..., 2])


DISTURBANCES = {"noise": TorqueNoise, "randomised": DomainRandomisation}


def disturbance(name: str, sim: BatchSim) -> Disturbance | None:
    """The disturbance of a name, for a simulator with HAMR-simple's parameters; None for the empty name."""
    if name and name not in DISTURBANCES:
        raise ConfigError(f"There is no disturbance '{name}': known are {', '.join(DISTURBANCES)}.")
    return DISTURBANCES[name](sim) if name else None
