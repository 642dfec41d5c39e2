"""Collect a bag of the robot, driven open loop: hung up and by passive white noise on all eight actuators, unless told otherwise.

Examples:
  hamr collect --backend full --out out/noise
  hamr collect --backend full --out out/noise --seconds 3 --seed 1 --band-hz 100 --std-volt 40 --direct
  hamr collect --backend full --out out/measured --as-measured
  hamr collect --backend simple --effects effects.yaml --out out/friction
  hamr collect --backend full --out out/trot --kind trot --frequency-hz 30 --amplitude-volt 50
  hamr collect --backend full --out out/again --play out/gap/experiment --as-measured
  hamr collect --backend full --environment ground --kind trot --frequency-hz 16 --seconds 12 --out out/walk --as-measured
"""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    out: Path
    """Folder of the bag."""
    backend: str = "full"
    """full, residual, simple or simple_published."""
    environment: Literal["suspended", "ground"] = "suspended"
    """suspended: hung up, its feet in the air; ground: on its feet."""
    residual: str = ""
    """Residual model file, for the residual backend; the shipped one if not given."""
    effects: str = ""
    """Effects file: what is added to the model (docs/effects.md)."""
    kind: str = "noise"
    """noise, trot, pronk, triangle, steps, or mix: all of them one after the other."""
    seconds: float | None = None
    """Simulated time; what is not given of this and the next four has the default of the kind (hamr_bags/signals.py)."""
    band_hz: float | None = None
    """noise: highest frequency."""
    std_volt: float | None = None
    """noise: standard deviation about neutral, before the clip."""
    frequency_hz: float | None = None
    """trot, pronk, triangle: cycles per second."""
    amplitude_volt: float | None = None
    """All but noise: about neutral, before the clip."""
    seed: int = 0
    """Of everything random."""
    play: str = ""
    """Bag whose /servo/voltages are played instead, as `hamr gap` writes an experiment."""
    samples_per_frame: int = 16
    """Samples kept of each 4 ms: 16 is 4 kHz, 80 is 20 kHz."""
    direct: bool = False
    """In this process, without ROS: the same numbers, sooner."""
    as_measured: bool = False
    """As an instrumented robot would have given it: without what only a simulation knows, with encoder noise."""

    def run(self) -> dict:
        from hamr_bags.as_measured import as_measured
        from hamr_bags.excitation import excitation
        from hamr_bags.signals import KINDS

        from ..graph import Run
        from ..shipped import RESIDUAL

        given = {
            "seconds": self.seconds,
            "band_hz": self.band_hz,
            "std": self.std_volt,
            "frequency_hz": self.frequency_hz,
            "amplitude": self.amplitude_volt,
            "seed": self.seed if hasattr(KINDS.get(self.kind), "seed") else None,
        }
        if self.play:
            signal = excitation("bag", path=self.play, **({"seconds": self.seconds} if self.seconds else {}))
        else:
            signal = excitation(self.kind, **{key: number for key, number in given.items() if number is not None})
        with ExitStack() as stack:
            bag = Path(stack.enter_context(TemporaryDirectory()), "exact") if self.as_measured else self.out
            run = Run(
                backend=self.backend,
                environment=self.environment,
                residual=self.residual or (str(RESIDUAL) if self.backend == "residual" else ""),
                effects=self.effects,
                excitation=signal.parameters,
                bag=str(bag),
                seconds=signal.parameters["seconds"],
                real_time_factor=0.0,
                samples_per_frame=self.samples_per_frame,
                seed=self.seed,
            )
            figures = self._collect(run)
            if self.as_measured:
                as_measured(bag, self.out, seed=self.seed)
        return {"bag": str(self.out), **figures}

    def _collect(self, run) -> dict:
        if self.direct:
            from ..direct import direct

            return direct(run)
        from ..supervisor import up

        return up(run)
