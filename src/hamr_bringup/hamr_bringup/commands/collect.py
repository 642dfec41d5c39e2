"""Collect a passive white-noise bag: the suspended robot, driven by band-limited Gaussian voltages on all eight actuators.

Examples:
  hamr collect --backend full --out out/noise
  hamr collect --backend full --out out/noise --seconds 3 --seed 1 --band-hz 100 --std-volt 40 --direct
  hamr collect --backend full --out out/measured --as-measured
"""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    out: Path
    """Folder of the bag."""
    backend: str = "full"
    """full, residual, simple or simple_published."""
    residual: str = ""
    """Residual model file, for the residual backend; the shipped one if not given."""
    seconds: float | None = None
    """Simulated time; numbers.yaml has the default of this and the next two (group excitation)."""
    band_hz: float | None = None
    """Highest frequency."""
    std_volt: float | None = None
    """Standard deviation about neutral, before the clip."""
    seed: int = 0
    """Of the noise."""
    samples_per_frame: int = 16
    """Samples kept of each 4 ms: 16 is 4 kHz, 80 is 20 kHz."""
    direct: bool = False
    """In this process, without ROS: the same numbers, sooner."""
    as_measured: bool = False
    """As an instrumented robot would have given it: without what only a simulation knows, with encoder noise."""

    def run(self) -> dict:
        from hamr_bags.as_measured import as_measured
        from hamr_bags.excitation import excitation

        from ..graph import Run
        from ..shipped import RESIDUAL

        given = {"seconds": self.seconds, "band_hz": self.band_hz, "std": self.std_volt}
        noise = excitation("noise", seed=self.seed, **{key: number for key, number in given.items() if number is not None})
        with ExitStack() as stack:
            bag = Path(stack.enter_context(TemporaryDirectory()), "exact") if self.as_measured else self.out
            run = Run(
                backend=self.backend,
                environment="suspended",
                residual=self.residual or (str(RESIDUAL) if self.backend == "residual" else ""),
                excitation=noise.parameters,
                bag=str(bag),
                seconds=noise.parameters["seconds"],
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
