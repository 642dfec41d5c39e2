"""A case's run with other noise, and half of it as it was, for whether the verdict stays: python -m hamr_gap.bench.other OUT NUMBER"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import hidden_gap

from .cases import case_of, recorded, samples_of, store
from .second import NOISE

WAYS = ("noise", "half")


def file_of(out: Path, way: str, name: int) -> Path:
    """Where such a run lies."""
    return out / way / f"{name}.npz"


def measure_otherwise(out: Path, name: int) -> None:
    """Writes both."""
    case = case_of(out / "answers" / f"{name}.json")
    truth = hidden_gap.simulate(case)
    volts = recorded(case, truth)
    store(file_of(out, "noise", name), samples_of(case, truth, hidden_gap.measured(replace(case, seed=case.seed + NOISE), truth), volts))
    whole = samples_of(case, truth, hidden_gap.measured(case, truth), volts)
    half = len(whole.angles) // 2
    tips = None if whole.deflections is None else whole.deflections[:half]
    part = replace(whole, voltages=volts[: half * (len(volts) // len(whole.angles))], angles=whole.angles[:half], deflections=tips)
    store(file_of(out, "half", name), part)


if __name__ == "__main__":
    measure_otherwise(Path(sys.argv[1]), int(sys.argv[2]))
