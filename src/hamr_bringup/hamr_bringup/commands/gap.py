"""Find where a model and measured bags disagree, name the effect that is missing, add it, and show the gap shrink.

Only time, drive voltages, hip angles and actuator deflections are read, of suspended runs, from any recorder. The folder gets
verdict.json, effects.yaml (for --effects of every command), report.html and a bag of measured and simulated angles. An interrupted
call goes on where it was.

Examples:
  hamr gap --measured out/measured --backend simple
  hamr gap --measured out/measured out/more --holdout out/holdout --backend full --out out/gap
  hamr gap --plant machine.py:model --measured run.csv --holdout other.csv
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    measured: Annotated[tuple[Path, ...], arg(metavar="BAG [BAG ...]")]
    """Bags of the machine."""
    backend: str = "simple"
    """The model to be completed: simple, simple_published, full or residual."""
    plant: str = ""
    """FILE.py:NAME of a function that returns the model of another machine; the bags are then tables (docs/other_machines.md)."""
    holdout: Annotated[tuple[Path, ...], arg(metavar="BAG [BAG ...]")] = ()
    """Bags that are opened only when the answer is fixed, to show the gap on; if none, a part of the measured ones serves."""
    out: Path = Path("out/gap")
    """Folder for all that is found."""
    seed: int = 0
    """Of the noise in a proposed experiment; nothing else is random."""

    def run(self) -> dict:
        if self.plant:
            from hamr_gap.plants import run as run_plant

            return run_plant(self.plant, self.measured, self.out, holdout=self.holdout)
        from hamr_gap.gap import run

        return run(self.measured, self.out, backend=self.backend, holdout=self.holdout, seed=self.seed)

    def text(self, result: dict) -> str:
        """The verdict in plain sentences."""
        from hamr_gap.words import sentences

        kinds = (("Effects", "effects_file"), ("Report", "report"), ("Angles", "overlay"))
        files = [f"{name}: {result[key]}" for name, key in kinds if result.get(key)]
        return "\n".join([*sentences(result), "", *files, f"Again: {result['command']}", ""])
