"""HAMR's legs as machines, and a bag's measured samples as their records."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np

from hamr_description.mirror import end
from hamr_description.names import AXES, JOINTS, MIRROR, drive_sign, joint_signs
from hamr_description.numbers import value
from hamr_description.rates import SERVO_MS
from hamr_description.simple_constants import simple_constants
from hamr_description.units import length_from_si
from hamr_dynamics.machine import Machine, leg_machine
from hamr_dynamics.plant import plant

from .data.record import Record

NEAR_STOP = 0.95  # of the way to an end stop, that a tip must have gone to have met it: its sensor is off by some per cent
#: For which a hit is remembered, as long as it leaves this share of the readings: how hard it was rings on for five time constants of the
#: slowest motion (94 ms), and counts less and less.
SHAKEN_MS = ((480.0, 0.5), (240.0, 0.5), (120.0, 0.2))


class Measured(Protocol):
    """What `measured.read` gives, and `hamr_bags.reader.load`; SI, one column a joint."""

    voltages: np.ndarray
    angles: np.ndarray
    deflections: np.ndarray | None
    sample_hz: float


def machine_of(backend: str, leg: str) -> Machine:
    """The suspended leg of a backend."""
    return leg_machine(plant(backend), leg, gravity=value("robot.gravity"))


def record_of(measured: Measured, leg: str, joints: Sequence[str] = JOINTS) -> Record:
    """A leg's samples in the leg frame (rad, mm, V from neutral, ms); columns are `joints`."""
    columns = [list(joints).index(f"{leg}_{kind}") for kind in ("swing", "lift")]
    drives = (measured.voltages[:, columns] - value("actuator.neutral_voltage")) * drive_sign(leg)
    readings, channels = [measured.angles[:, columns] * np.array(joint_signs(leg), float)], [f"{leg}_swing", f"{leg}_lift"]
    if measured.deflections is not None:
        readings.append(length_from_si(measured.deflections[:, columns]) * MIRROR[leg][1])
        channels += [f"{name}_actuator" for name in channels]
    per = len(measured.voltages) // len(measured.angles)
    return clear_of_stops(
        Record(drives, np.hstack(readings), 1e3 / measured.sample_hz, tuple(channels), hold=SERVO_MS, drives_per_reading=per)
    )


def clear_of_stops(record: Record) -> Record:
    """The record without the readings just after an actuator met its end stop: how hard it hit decides on too much that follows.

    Where tips were not measured, hip angles tell: those that HAMR-simple has at its stops (`simple.yaml`). Where hits come so often that
    little would be left, all stay.
    """
    tips = [i for i, name in enumerate(record.channels) if name.endswith("_actuator")] or range(len(record.channels))
    low, high = np.array([_stops(record.channels[i]) for i in tips]).T
    seen = np.nan_to_num(record.readings[:, tips])
    hit = ((seen < NEAR_STOP * low) | (seen > NEAR_STOP * high)).any(1)
    for ms, enough in SHAKEN_MS:
        clear = np.convolve(hit, np.ones(int(ms / record.step)))[: len(hit)] == 0
        if clear.mean() >= enough:
            return replace(record, readings=np.where(clear[:, None], record.readings, np.nan), shaken=float(1.0 - clear.mean()))
    return record


def _stops(channel: str) -> tuple[float, float]:
    """What a channel reads at the lower and at the upper end stop of its actuator (mm of a tip, rad of a hip)."""
    leg, axis, *tip = channel.split("_")
    if tip:
        return -value("actuator.stop"), value("actuator.stop")
    hip = simple_constants()[end(leg)]
    return tuple(hip[f"stop_{side}"][AXES.index(axis)] for side in ("low", "high"))
