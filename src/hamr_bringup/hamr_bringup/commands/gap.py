"""Find where a model and measured bags disagree, name the effect that is missing, add it, and show the gap shrink.

Only time, drive voltages, hip angles and actuator deflections are read, and of walks the chassis's pose, from any recorder. The folder gets
verdict.json, effects.yaml (for --effects of every command), report.html and a bag of measured and simulated angles. An interrupted
call goes on where it was. `hamr gap bench` draws machines with hidden effects, finds them blind and scores the answers.

Examples:
  hamr gap --measured out/measured --backend simple
  hamr gap --measured out/measured out/more --holdout out/holdout --backend full --out out/gap
  hamr gap --plant machine.py:model --measured run.csv --holdout other.csv
  hamr gap bench --set development --singles 4 --nulls 2
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from tyro.conf import arg


@dataclass(frozen=True, slots=True, kw_only=True)
class Study:
    """Bags in, verdict out."""

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
        from hamr_gap.showing.words import sentences

        kinds = (("Effects", "effects_file"), ("Report", "report"), ("Angles", "overlay"))
        files = [f"{name}: {result[key]}" for name, key in kinds if result.get(key)]
        return "\n".join([*sentences(result), "", *files, f"Again: {result['command']}", ""])


@dataclass(frozen=True, slots=True, kw_only=True)
class Bench:
    """Machines with hidden effects, drawn by another program, found blind and scored; an interrupted call goes on where it was."""

    set: Literal["development", "calibration", "report"] = "development"
    """Seeds: thresholds were chosen on the first, probabilities on the second, and the third is for figures."""
    singles: int = 0
    """Cases with one effect."""
    pairs: int = 0
    """Cases with two."""
    triples: int = 0
    """Cases with three."""
    nulls: int = 0
    """Cases with none: nothing, other parameters, bad noise, a coarser step."""
    outside: int = 0
    """Cases with a law that no library names."""
    twins: int = 0
    """Cases under conditions that hide the difference between names."""
    ground: int = 0
    """Cases with one effect, of the whole robot walking on the ground."""
    ground_nulls: int = 0
    """Cases with none, likewise: nothing, other parameters."""
    first: int = 0
    """Number of the first case of each kind."""
    strength: float = 5.0
    """Of each effect: what the best re-tuned model leaves, in floors."""
    seconds: float = 12.0
    """Of each record."""
    again: bool = False
    """Also make the experiments that verdicts ask for, and settle them with both runs."""
    stable: bool = False
    """Also solve cases with other noise, and from half of the data."""
    ideals: bool = False
    """Also ask noise-free data what they could have told: which names, and the right ones' parameters."""
    workers: int = 2
    """Processes."""
    out: Path = Path("out/gap_bench")
    """Folder of cases, answers and verdicts."""
    verdicts: str = "verdicts"
    """Name of the folder of verdicts, for another version of the solver on the same cases."""

    def run(self) -> dict:
        from dataclasses import asdict

        from hamr_gap.bench.run import bench

        return bench(**asdict(self))


class Command:
    """One word or two."""

    @staticmethod
    def from_words(argv: list[str]) -> Study | Bench:
        """Reads the arguments."""
        import tyro

        if argv[:1] == ["bench"]:
            return tyro.cli(Bench, prog="hamr gap bench", args=argv[1:])
        description = f"{__doc__}\nWith --json, standard output is one JSON object."
        return tyro.cli(Study, prog="hamr gap", description=description, args=argv)
