"""A proposed experiment as a bag of drive voltages, to be played to the robot."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from shutil import rmtree

import numpy as np

from hamr_bags.frames import servo_frame
from hamr_bags.writer import BagWriter
from hamr_description.names import AXES, JOINTS, Topic, drive_sign
from hamr_description.numbers import value
from hamr_description.rates import SERVO_HZ, SUBSTEPS, TARGET_NS
from hamr_description.units import time_to_si

from .record import Record
from .resample import resampled


def write_drives(drives: Mapping[str, np.ndarray], records: Mapping[str, Record], path: Path) -> None:
    """Writes /servo/voltages at the servo rate, other joints at neutral; in place of an older bag.

    Args:
        drives: leg -> (n, 2) V about neutral in the leg's frame, at the drive's steps of its record.
    """
    if path.exists():
        rmtree(path)
    every = {leg: volts_of(leg, x, records[leg]) for leg, x in drives.items()}
    frames = -(-max(len(x) for x in every.values()) // SUBSTEPS)
    volts = np.full((frames * SUBSTEPS, len(JOINTS)), value("actuator.neutral_voltage"))
    for leg, x in every.items():
        volts[: len(x), [JOINTS.index(f"{leg}_{axis}") for axis in AXES]] = x
    frame = servo_frame(Topic.SERVO_VOLTAGES, SUBSTEPS)
    with BagWriter(path) as bag:
        for k in range(frames):
            frame.stamp(k * TARGET_NS)
            frame.numbers["effort"][:] = volts[k * SUBSTEPS : (k + 1) * SUBSTEPS]
            bag.write(Topic.SERVO_VOLTAGES, bytes(frame), k * TARGET_NS)


def volts_of(leg: str, drives: np.ndarray, record: Record) -> np.ndarray:
    """(m, 2) V at the servo rate of a leg's drives (n, 2) V about neutral in its frame, at the drive's steps of a record."""
    per = round(time_to_si(record.step) / record.drives_per_reading * SERVO_HZ)
    fine = np.stack([resampled(u, per, within=0.0) for u in drives.T], 1)
    low, neutral, high = (value(f"actuator.{name}_voltage") for name in ("ground", "neutral", "bias"))
    return np.clip(neutral + drive_sign(leg) * fine, low, high)
