"""Cases for the solver and, elsewhere, their answers.

A case file holds what a sensor would have recorded and nothing else; its name is a number. Answers are written to another folder,
and a hash of them all is written down before any is solved.
"""

from __future__ import annotations

import hashlib
import json
import shutil
from dataclasses import asdict
from pathlib import Path

import numpy as np

import hidden_gap
from hidden_gap import ground
from hidden_gap.case import JOINTS, LEG, Case, Effect, Truth

from ..data.measured import Samples
from ..data.record import Record
from ..legs import record_of

JUMPS = ("mix", "steps", "triangle")  # excitations whose drive is recorded at its own rate: slower samples lose when it jumps
GROUPS = {"single": 0, "pair": 1, "triple": 2, "null": 3, "outside": 4, "twins": 5, "ground": 6, "ground_null": 7}
SETS = {"development": 100_000, "calibration": 200_000, "report": 300_000}


def number(group: str, set_: str, index: int) -> int:
    """Name and seed of a case."""
    return SETS[set_] + 10_000 * GROUPS[group] + index


def make(folder: Path, group: str, set_: str, index: int, *, strength: float, seconds: float) -> None:
    """Draws a case, unless it is there."""
    name = number(group, set_, index)
    file, answer_file = path(folder, name), folder / "answers" / f"{name}.json"
    if file.exists() and answer_file.exists():
        return
    if group in ground.GROUPS:
        shutil.rmtree(file, ignore_errors=True)  # half of a bag, if there is
        file.parent.mkdir(parents=True, exist_ok=True)
        answer = ground.write(ground.draw(group, name, strength=strength, seconds=seconds), file)
    else:
        case = hidden_gap.draw(group, name, strength=strength, seconds=seconds)
        truth = hidden_gap.simulate(case)
        store(file, samples_of(case, truth, hidden_gap.measured(case, truth), recorded(case, truth)))
        answer = asdict(case)
    answer_file.parent.mkdir(parents=True, exist_ok=True)
    answer_file.write_text(json.dumps(answer, indent=1))


def path(folder: Path, name: int) -> Path:
    """Where a case lies: a file of a leg, or the bag of a robot on the ground."""
    walks = name % 100_000 // 10_000 in (GROUPS[group] for group in ground.GROUPS)
    return folder / "cases" / (str(name) if walks else f"{name}.npz")


def case_of(answer: Path) -> Case:
    """The case of an answer file."""
    return from_plain(json.loads(answer.read_text()))


def from_plain(content: dict) -> Case:
    """A case from what `asdict` made of it."""
    effects = tuple(Effect(e["family"], tuple(e["joints"]), e["law"], e["parameters"]) for e in content["effects"])
    tuples = {key: tuple(content[key]) for key in ("channels", "reached") if key in content}
    return Case(**content | tuples | {"effects": effects})


def store(path: Path, samples: Samples) -> None:
    """Writes a case file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    tips = {} if samples.deflections is None else {"deflections": samples.deflections}
    np.savez(path, sample_hz=samples.sample_hz, voltages=samples.voltages, angles=samples.angles, **tips)


def load(path: Path) -> Record:
    """The record of a case."""
    with np.load(path, allow_pickle=False) as f:
        tips = f.get("deflections")
        return record_of(Samples(JOINTS, 0.0, float(f["sample_hz"]), f["voltages"], f["angles"], tips), LEG, JOINTS)


def digest(folder: Path, names: list[int]) -> str:
    """Hash of the answers of some cases."""
    sha = hashlib.sha256()
    for name in sorted(names):
        sha.update((folder / "answers" / f"{name}.json").read_bytes())
    return sha.hexdigest()


def recorded(case: Case, truth: Truth) -> np.ndarray:
    """(n, 2) V of a case's excitation as its bag has them."""
    return hidden_gap.commands(**case.excitation) if case.excitation["kind"] in JUMPS else truth.volts


def samples_of(case: Case, truth: Truth, seen: Truth, volts: np.ndarray) -> Samples:
    """What was measured: lost samples are NaN, tips that have no sensor None."""
    hz = 1.0 / float(truth.time[1] - truth.time[0])
    at = np.round(seen.time * hz).astype(int)
    angles, tips = (np.full(truth.angles.shape, np.nan) for _ in range(2))
    angles[at], tips[at] = seen.angles, seen.tips
    return Samples(JOINTS, 0.0, hz, volts, angles, tips if "deflections" in case.channels else None)
