"""How long the engine takes for a leg with the machine to itself, on all of its cores (a benchmark solves one case on each core).

    python -m hamr_gap.bench.alone out/gap_bench

An analysis of the first case comes before the clock starts: kernels are compiled once a machine and kept.
"""

from __future__ import annotations

import json
import sys
from itertools import islice
from pathlib import Path
from time import perf_counter

import numpy as np
import tyro
from tqdm import tqdm

from hamr_description.errors import ConfigError, HamrError

from ..judging.analyse import analyse
from ..legs import machine_of
from .cases import LEG, load


def seconds(case: Path) -> float:
    """Wall seconds from a record to a verdict."""
    machine, record = machine_of("simple", LEG), load(case)
    began = perf_counter()
    analyse(machine, record)
    return perf_counter() - began


def main(out: tyro.conf.Positional[Path], cases: int = 12) -> None:
    """Prints median and 90th percentile of wall seconds.

    Args:
        out: folder of a benchmark. cases: so many, the first by number.
    """
    files = list(islice(sorted((out / "cases").glob("*.npz")), cases))
    if not files:
        raise ConfigError(f"There is no case in {out / 'cases'}; draw some with 'hamr gap bench --out {out}'.")
    seconds(files[0])
    took = {int(file.stem): round(seconds(file), 1) for file in tqdm(files, unit="case")}
    middle, most = np.percentile(list(took.values()), [50, 90])
    sys.stdout.write(json.dumps({"median": round(middle, 1), "90th percentile": round(most, 1), "cases": took}) + "\n")


if __name__ == "__main__":
    try:
        tyro.cli(main)
    except HamrError as error:
        sys.exit(str(error))
