"""Learn a residual from bags alone, offline.

Examples:
  hamr train residual --bag out/noise --out out/residual.json
  hamr train residual --bag out/noise out/more --out out/paper.json --method paper --architecture robot --seed 1 --resume
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg


@dataclass(frozen=True, slots=True, kw_only=True)
class Residual:
    """Learn a residual from suspended bags: time, voltages, hip angles and tip deflections, nothing else."""

    bag: Annotated[tuple[Path, ...], arg(metavar="BAG [BAG ...]")]
    """Bags of `hamr collect`, or of a robot."""
    out: Path
    """Model file to write."""
    method: str = "adjoint"
    """adjoint, or paper: the published method with a surrogate network."""
    architecture: str = ""
    """adjoint: series:DEGREE; paper: leg or robot; the method's own if not given."""
    seed: int = 0
    """Of everything random."""
    resume: bool = False
    """Go on from the checkpoint that an interrupted call left beside the model file."""

    def run(self) -> dict:
        from hamr_bags.reader import load
        from hamr_sim_residual.train import train

        recordings = [load(bag) for bag in self.bag]
        return train(recordings, self.out, method=self.method, architecture=self.architecture, seed=self.seed, resume=self.resume)


Command = {"residual": Residual}
