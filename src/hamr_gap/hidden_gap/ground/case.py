"""What a hidden case on the ground is, its noise-free run, and how its conditions are drawn."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from hamr_bags.excitation import excitation
from hamr_description.names import JOINTS

from ..case import Hidden
from ..conditions import SPREAD, changes
from .machine import STEP, Walk
from .strength import Floors, walked

#: Noise of the encoders, share of the stroke.
NOISE = (2e-3, 1e-2)
KINDS = tuple(kind for kind in SPREAD if not kind.startswith("tip"))


@dataclass(frozen=True, slots=True)
class GroundCase(Hidden):
    """A hidden robot that walks. Effects of legs act at all joints or those of an axis, those of body and contact at none.

    Attributes:
        position_noise, orientation_noise: of motion capture, m and rad.
        strength: asked, in floors.
        reached: that of the channel which shows the effects most, over segments of 20 ms, after a re-tune (ground_retune.left).
        channels: that of every channel.
        step: integration step, ms.
    """

    position_noise: float = 5e-5
    orientation_noise: float = 2e-3
    strength: float = 5.0
    reached: float = 0.0
    channels: dict[str, float] = field(default_factory=dict)
    step: float = STEP

    @property
    def floors(self) -> Floors:
        """Of its sensors."""
        return Floors.of(self.noise, self.position_noise, self.orientation_noise)

    def volts(self, seconds: float | None = None) -> np.ndarray:
        """(n, 8) V at 20 kHz; of an excitation of the same kind if `seconds` differ."""
        return excitation(**self.excitation | {"seconds": seconds or self.seconds}).voltages

    def run(self) -> Walk:
        """Without noise; ModelError if it diverges or the robot falls over."""
        return walked(self.effects, self.changes, self.volts(), step=self.step)


def conditions(group: str, seed: int, strength: float, seconds: float, random: np.random.Generator) -> GroundCase:
    """A case without effects: half of them trot; changes of parameters in 7 of 10."""
    noise = float(np.exp(random.uniform(*np.log(NOISE))))
    hidden = changes(random, JOINTS, KINDS) if random.random() < 0.7 else {}
    return GroundCase(f"{group}-{seed}", group, seed, (), hidden, seconds, _signal(seconds, random), noise, strength=strength)


def _signal(seconds: float, random: np.random.Generator) -> dict:
    """Gaits and noise that do not turn the robot over."""
    kind = ("trot", "trot", "pronk", "noise")[random.integers(4)]
    if kind == "noise":
        band, std = float(random.uniform(15.0, 50.0)), float(random.uniform(25.0, 40.0))
        return {"kind": kind, "seconds": seconds, "seed": int(random.integers(2**31)), "band_hz": band, "std": std}
    hertz = float(np.exp(random.uniform(np.log(3.0), np.log(25.0))))
    return {
        "kind": kind,
        "seconds": seconds,
        "frequency_hz": hertz,
        "amplitude": float(random.uniform(40.0, 75.0 if kind == "trot" else 50.0)),
    }
