"""Parameters of every simulator node."""

from __future__ import annotations

import json
from dataclasses import dataclass
from math import inf
from typing import ClassVar

from hamr_bags.run_info import ENVIRONMENTS
from hamr_description.errors import ConfigError
from hamr_description.numbers import number
from hamr_description.rates import TARGET_HZ

from .parameters import parameter
from .run import DRIVER, RECORDER, BusParameters

_FRICTION = number("contact.friction")


@dataclass(frozen=True, slots=True)
class SimulatorParameters(BusParameters):
    """Parameters of every simulator node."""

    may_wait_for: ClassVar[tuple[str, ...]] = (DRIVER, RECORDER)

    engine: str = parameter("kernel", "kernel or mujoco")
    environment: str = parameter("ground", "ground or suspended")
    friction: float = parameter(_FRICTION.value, "friction coefficient of the ground")
    effects: str = parameter("", "effects file: what is added to the model; empty for nothing")
    seed: int = parameter(0, "seed of every reset")
    real_time_factor: float = parameter(1.0, "sim time over wall time; 0 for as fast as possible", live=True)
    duration: float = parameter(0.0, "s of sim time after which the node ends; 0 for never")
    driver_patience: float = parameter(2.0, "longest wait for a driver that is on the bus, s of wall time")
    excitation: str = parameter("", "parameters of the excitation that drives, JSON, for /run_info")
    report: str = parameter("", "file for a report at the end, JSON: simulated_s, wall_s, real_time_factor, counts; empty for none")

    def __post_init__(self) -> None:
        BusParameters.__post_init__(self)
        if self.environment not in ENVIRONMENTS:
            raise ConfigError(f"environment is '{self.environment}'; choose one of {', '.join(ENVIRONMENTS)}.")
        low, high = _FRICTION.bounds
        if not low <= self.friction <= high:
            raise ConfigError(f"friction is {self.friction}; choose {low} to {high}.")
        if not (self.real_time_factor >= 0 and self.duration >= 0 and self.driver_patience > 0):
            raise ConfigError("real_time_factor and duration must not be negative, and driver_patience must be positive.")
        try:
            if not isinstance(json.loads(self.excitation or "{}"), dict):
                raise ValueError
        except ValueError:
            raise ConfigError(f"excitation is {self.excitation!r}; it must be a JSON object.") from None

    @property
    def periods(self) -> float:
        """Periods to simulate; infinite for no end."""
        return round(self.duration * TARGET_HZ) or inf
