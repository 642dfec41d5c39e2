"""Bags of one leg for the tests of `hamr gap`: cut out of a run of the whole robot, as a bench that holds one leg would record it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hamr_bags.cdr import NS, string
from hamr_bags.frames import trajectory_layout
from hamr_bags.layout import Frame
from hamr_bags.reader import load
from hamr_bags.recording import Recording
from hamr_bags.run_info import RunInfo
from hamr_bags.writer import BagWriter
from hamr_bringup.direct import direct
from hamr_bringup.graph import Run
from hamr_description.names import JOINTS, Topic
from hamr_description.rates import TARGET_NS

LEG = "rr"  # the one whose every sign is turned
PER_FRAME = 16


def record(path: Path, effects: str, *, seconds: float, seed: int, kind: str = "noise") -> Recording:
    """A run of the suspended HAMR-simple with effects, everything that the simulation knows."""
    signal = {"kind": kind, "seconds": seconds, "seed": seed}
    direct(Run(backend="simple", environment="suspended", effects=effects, excitation=signal, bag=str(path), seconds=seconds, seed=seed))
    return load(path, truth=True)


def write(
    path: Path, run: Recording, *, noise: float, seed: int, joints: tuple[str, ...], info: dict | None = None, **more: np.ndarray
) -> Path:
    """Angles and deflections of some joints with noise (a share of the rms), drive voltages, and whatever other fields are given."""
    random = np.random.default_rng(seed)
    columns = [JOINTS.index(joint) for joint in joints]
    angles, tips = (x[:, columns] + noise * x[:, columns].std() * random.standard_normal((len(x), len(joints))) for x in
                    (run.angles, run.deflections))  # fmt: skip
    actuators = tuple(f"{joint}_actuator" for joint in joints)
    topics = {
        Topic.SERVO_JOINTS: (joints, {"positions": angles, **more}), Topic.SERVO_ACTUATORS: (actuators, {"positions": tips}),
        Topic.SERVO_VOLTAGES: (actuators, {"effort": run.voltages[:, columns]}),
    }  # fmt: skip
    said = RunInfo(environment="suspended", samples_per_frame=PER_FRAME, **(info or {}))
    with BagWriter(path) as bag:
        bag.write(Topic.RUN_INFO, string(said.to_json()), 0)
        for k in range(len(angles) // PER_FRAME):
            part = slice(k * PER_FRAME, (k + 1) * PER_FRAME)
            for topic, (names, fields) in topics.items():
                frame = Frame(trajectory_layout(names, tuple(fields), PER_FRAME))
                since = np.arange(PER_FRAME) * (TARGET_NS // PER_FRAME)
                frame.numbers["time_from_start"][:] = np.stack(np.divmod(since, NS), axis=-1)
                frame.stamp(k * TARGET_NS)
                for name, values in fields.items():
                    frame.numbers[name][:] = values[part]
                bag.write(topic, bytes(frame), k * TARGET_NS)
    return path
