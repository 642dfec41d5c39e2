"""Parameters that the nodes of one run share, and what a node may wait for before it takes part."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from hamr_bags.frames import SAMPLES_PER_FRAME
from hamr_description.errors import ConfigError

from .parameters import parameter

DRIVER, TARGETS, RECORDER = "driver", "targets", "recorder"


@dataclass(frozen=True, slots=True)
class RunParameters:
    """Parameters of every node that takes part in the lock-step."""

    may_wait_for: ClassVar[tuple[str, ...]] = (RECORDER,)

    wait_for: str = parameter("", "what must be there before this node takes part, by name, with commas")

    def __post_init__(self) -> None:
        for name in self.awaited:
            if name not in self.may_wait_for:
                raise ConfigError(f"wait_for names '{name}'; this node can wait for {' and '.join(self.may_wait_for)}.")

    @property
    def awaited(self) -> frozenset[str]:
        """The names in wait_for."""
        return frozenset(name.strip() for name in self.wait_for.split(",") if name.strip())


@dataclass(frozen=True, slots=True)
class BusParameters(RunParameters):
    """Parameters of the nodes on the servo bus."""

    run: str = parameter("main", "name of the run; simulator and driver of one run meet on one servo bus")
    samples_per_frame: int = parameter(16, "servo samples in each /servo message, a divisor of 80")

    def __post_init__(self) -> None:
        RunParameters.__post_init__(self)
        if self.samples_per_frame not in SAMPLES_PER_FRAME:
            choices = ", ".join(map(str, SAMPLES_PER_FRAME))
            raise ConfigError(f"samples_per_frame is {self.samples_per_frame}; choose one of {choices}.")
