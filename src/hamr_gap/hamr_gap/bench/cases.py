"""Cases for the solver and, elsewhere, their answers.

A case file holds what a sensor would have recorded and nothing else; its name is a number. Answers are written to another folder,
and a hash of them all is written down before any is solved.
"""

from __future__ import annotations

import hashlib
import json
import sys
from dataclasses import asdict
from pathlib import Path

import numpy as np

import hidden_gap
from hamr_bags.as_measured import strokes
from hamr_description.names import Topic, drive_sign, joint_signs
from hamr_description.numbers import value
from hamr_description.units import length_from_si

from ..legs import clear_of_stops
from ..record import Record

LEG = "fl"
JUMPS = ("mix", "steps", "triangle")  # excitations whose drive is recorded at its own rate: slower samples lose when it jumps
GROUPS = {"single": 0, "pair": 1, "triple": 2, "null": 3, "outside": 4, "twins": 5}
SETS = {"development": 100_000, "calibration": 200_000, "report": 300_000}


def number(group: str, set_: str, index: int) -> int:
    """Name and seed of a case."""
    return SETS[set_] + 10_000 * GROUPS[group] + index


def make(folder: Path, group: str, set_: str, index: int, *, strength: float, seconds: float) -> None:
    """Draws a case, unless it is there."""
    name = number(group, set_, index)
    case_file, answer_file = folder / "cases" / f"{name}.npz", folder / "answers" / f"{name}.json"
    if case_file.exists() and answer_file.exists():
        return
    case = hidden_gap.draw(group, name, strength=strength, seconds=seconds)
    truth = hidden_gap.simulate(case)
    seen = hidden_gap.measured(case, truth)
    record = record_of(case, truth, seen)
    for path in (case_file, answer_file):
        path.parent.mkdir(parents=True, exist_ok=True)
    np.savez(
        case_file, drives=record.drives, readings=record.readings, step=record.step, channels=record.channels,
        drives_per_reading=record.drives_per_reading,
    )  # fmt: skip
    noise = case.noise * np.array([strokes()[Topic.SERVO_JOINTS]] * 2 + [length_from_si(strokes()[Topic.SERVO_ACTUATORS])] * 2)
    np.savez(answer_file.with_suffix(".npz"), readings=_readings(truth), noise=noise)
    answer_file.write_text(json.dumps(asdict(case), indent=1))


def load(path: Path) -> Record:
    """The record of a case."""
    with np.load(path, allow_pickle=False) as f:
        per = int(f["drives_per_reading"])
        return clear_of_stops(
            Record(f["drives"], f["readings"], float(f["step"]), tuple(map(str, f["channels"])), held=per > 1, drives_per_reading=per)
        )


def digest(folder: Path, names: list[int]) -> str:
    """Hash of the answers of some cases."""
    sha = hashlib.sha256()
    for name in sorted(names):
        sha.update((folder / "answers" / f"{name}.json").read_bytes())
    return sha.hexdigest()


def _readings(run) -> np.ndarray:
    return np.hstack([run.angles * np.array(joint_signs(LEG), float), length_from_si(run.tips) * joint_signs(LEG)[1]])


def record_of(case, truth, seen) -> Record:
    """What was measured: lost samples are NaN, channels without a sensor are left out."""
    joints = (f"{LEG}_swing", f"{LEG}_lift")
    channels = (*joints, *(f"{joint}_actuator" for joint in joints))
    step = 1e3 * float(truth.time[1] - truth.time[0])
    readings = np.full((len(truth.time), 4), np.nan)
    readings[np.round(seen.time / (truth.time[1] - truth.time[0])).astype(int)] = _readings(seen)
    kept = [i for i in range(4) if np.isfinite(readings[:, i]).any()]
    drives, per = truth.volts, 1
    if case.excitation["kind"] in JUMPS:
        drives = sys.modules["hidden_gap.simulate"].commands(**case.excitation)
        per = len(drives) // len(readings)
    drives = (drives - value("actuator.neutral_voltage")) * drive_sign(LEG)
    return clear_of_stops(Record(drives, readings[:, kept], step, tuple(channels[i] for i in kept), held=per > 1, drives_per_reading=per))
