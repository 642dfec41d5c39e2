"""Drive voltages that a bag holds, played again: an experiment that `hamr gap` asks for, or a run of a robot."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import ClassVar

import numpy as np

from hamr_description.errors import BagError
from hamr_description.names import Topic
from hamr_description.numbers import value
from hamr_description.rates import SERVO_HZ

from .bag import open_bag
from .decode import decode_all
from .frames import SERVO_NAMES
from .signals import samples
from .topics import TRAJECTORY


@dataclass(frozen=True, slots=True, kw_only=True)
class Replay:
    """A bag's `/servo/voltages` at the servo's own rate; `seconds`: 0 for all of it."""

    kind: ClassVar[str] = "bag"
    path: str
    seconds: float = 0.0

    def __post_init__(self) -> None:
        whole = len(recorded(self.path)) / SERVO_HZ
        if self.seconds > whole:
            raise BagError(f"{self.path} holds {whole:g} s of voltages, {self.seconds:g} s were asked for; ask for less.")
        object.__setattr__(self, "seconds", self.seconds or whole)

    def deviation(self) -> np.ndarray:
        """(n, 8) V about neutral."""
        return recorded(self.path)[: samples(self.seconds)] - value("actuator.neutral_voltage")


@lru_cache(maxsize=2)
def recorded(path: str) -> np.ndarray:
    """(n, 8) V at the servo's rate; BagError if a bag holds none, or slower ones."""
    topic = Topic.SERVO_VOLTAGES
    with open_bag(Path(path)) as bag:
        bag.require(topic)
        raws = bag.raws(topic)[1]
    stamps, frames = [], []
    for _, numbers in decode_all(raws, TRAJECTORY, SERVO_NAMES[topic]):
        stamps.append(numbers["stamp"])
        frames.append((numbers["effort"], numbers["time_from_start"]))
    step = np.concatenate([np.diff(since, axis=-1).ravel() for _, since in frames])
    if not len(step) or not np.allclose(step * SERVO_HZ, 1e9, rtol=1e-3):
        raise BagError(f"{path} holds {topic} at another rate than the servo's {SERVO_HZ} Hz; record it with 80 samples to a message.")
    effort = np.concatenate([volts for volts, _ in frames])[np.argsort(np.concatenate(stamps), kind="stable")]
    return effort.reshape(-1, effort.shape[-1])
