"""The run that a verdict asked for, of the same hidden machine: python -m hamr_gap.bench.second OUT VERDICTS NUMBER"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

import hidden_gap
from hidden_gap.case import LEG, Case, Truth

from ..data.drives_bag import volts_of
from ..data.record import Record
from .cases import case_of, load, samples_of, store

FINER = 2  # times the step that the first run took: what it is asked for tells names apart that differ by little
NOISE = 10_000_000  # added to a case's seed for the noise of its second run


def folder_of(out: Path, verdicts: str) -> Path:
    """Where second runs lie: each belongs to a verdict."""
    return out / f"{verdicts}_asked"


def played(case: Case, first: Record, drives: np.ndarray) -> tuple[Truth, np.ndarray]:
    """A case's machine under drives (n, joints) about neutral, at the drive's steps of its record, and the voltages as a bag has them."""
    volts = volts_of(LEG, drives, first)
    truth = hidden_gap.driven(case.effects, case.changes, volts, step=case.step / FINER)
    return truth, volts if first.drives_per_reading > 1 else truth.volts


def measure_again(out: Path, verdicts: str, name: int) -> None:
    """Measures a case's machine anew, under the drives that a verdict asked for."""
    case, first = case_of(out / "answers" / f"{name}.json"), load(out / "cases" / f"{name}.npz")
    with np.load(out / verdicts / f"{name}.npz", allow_pickle=False) as f:
        truth, volts = played(case, first, f["drives"])
    seen = hidden_gap.measured(replace(case, seed=case.seed + NOISE), truth)
    store(folder_of(out, verdicts) / f"{name}.npz", samples_of(case, truth, seen, volts))


if __name__ == "__main__":
    measure_again(Path(sys.argv[1]), sys.argv[2], int(sys.argv[3]))
