"""A case as a bench with one leg would have recorded it; nothing in the bag or its folder tells what is hidden."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

import numpy as np

from hamr_bags.cdr import NS, string
from hamr_bags.frames import trajectory_layout
from hamr_bags.layout import Frame
from hamr_bags.run_info import CONDITIONS, RunInfo
from hamr_bags.writer import BagWriter
from hamr_description.names import Topic
from hamr_description.rates import TARGET_HZ

from .case import JOINTS, Case
from .noise import measured
from .simulate import SAMPLE_HZ, simulate

PER_FRAME = SAMPLE_HZ // TARGET_HZ


def write(case: Case, folder: str | Path) -> dict:
    """Write the case's bag into a new folder; BagError if it exists.

    /servo/joints and /servo/actuators hold positions, /servo/voltages holds effort, each with the leg's two joints and 16 samples
    per message; /run_info says rates, units and environment. Lost frames are absent.

    Returns:
        The answer, JSON-able: the case.
    """
    run, every = measured(case, truth := simulate(case)), np.round(truth.time * SAMPLE_HZ).astype(int)
    actuators = tuple(f"{joint}_actuator" for joint in JOINTS)
    topics = {Topic.SERVO_JOINTS: (JOINTS, "positions", run.time, run.angles)}
    if "deflections" in case.channels:
        topics[Topic.SERVO_ACTUATORS] = (actuators, "positions", run.time, run.tips)
    topics[Topic.SERVO_VOLTAGES] = (actuators, "effort", truth.time, truth.volts)
    frames = {topic: _Frames(*parts) for topic, parts in topics.items()}
    info = RunInfo(environment="suspended", samples_per_frame=PER_FRAME)
    with BagWriter(folder) as bag:
        bag.write(Topic.RUN_INFO, string(json.dumps({name: getattr(info, name) for name in CONDITIONS})), 0)
        for start in range(0, every.size, PER_FRAME):
            stamp = start * NS // SAMPLE_HZ
            for topic, frame in frames.items():
                if raw := frame(start, stamp):
                    bag.write(topic, raw, stamp)
    return asdict(case)


class _Frames:
    """The messages of one topic."""

    def __init__(self, joints: tuple[str, ...], field: str, time: np.ndarray, values: np.ndarray) -> None:
        self._row = {index: row for row, index in enumerate(np.round(time * SAMPLE_HZ).astype(int).tolist())}
        self._values, self._field = values, field
        self._frame = Frame(trajectory_layout(joints, (field,), PER_FRAME))
        since = np.arange(PER_FRAME) * (NS // SAMPLE_HZ)
        self._frame.numbers["time_from_start"][:] = np.stack(np.divmod(since, NS), axis=-1)

    def __call__(self, start: int, stamp: int) -> bytes:
        """The message that begins at sample `start`; empty if it was lost."""
        row = self._row.get(start)
        if row is None:
            return b""
        self._frame.stamp(stamp)
        self._frame.numbers[self._field][:] = self._values[row : row + PER_FRAME]
        return bytes(self._frame)
