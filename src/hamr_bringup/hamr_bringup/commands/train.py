"""Learn a residual from bags, offline, or a policy on a simulator.

Examples:
  hamr train residual --bag out/noise --out out/residual.json
  hamr train residual --bag out/noise out/more --out out/paper.json --method paper --architecture robot --seed 1 --resume
  hamr train policy --task walk --backend residual --out out/walk
  hamr train policy --task turn --backend full --out out/turn --steps 2000000 --seed 1 --resume
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg

from ..present import as_text


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


@dataclass(frozen=True, slots=True, kw_only=True)
class Policy:
    """Train a policy with PPO and export it: policy.onnx, its settings and curve, TensorBoard logs, checkpoints."""

    task: str
    """walk or turn."""
    backend: str
    """full, residual, simple or simple_published."""
    out: Path
    """Folder for all that training leaves."""
    residual: str = ""
    """Residual model file, for the residual backend; the shipped one if not given."""
    effects: str = ""
    """Effects file: what is added to the model (docs/effects.md)."""
    steps: int = 1_000_000
    """Of 4 ms, all robots together."""
    seed: int = 0
    """Of everything random."""
    resume: bool = False
    """Go on from the checkpoint in the folder."""

    def run(self) -> dict:
        from hamr_policy.train import train

        return train(self.task, self.backend, self.out, steps=self.steps, seed=self.seed, residual=self.residual, effects=self.effects,
                     resume=self.resume)  # fmt: skip

    def text(self, result: dict) -> str:
        """All but the curve's thousand points, which lie in the folder."""
        return as_text({key: value for key, value in result.items() if key != "curve"})


Command = {"residual": Residual, "policy": Policy}
