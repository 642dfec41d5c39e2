"""Measured and simulated angles side by side in a bag, for Foxglove or PlotJuggler."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from shutil import rmtree

import numpy as np

from hamr_bags.cdr import NS
from hamr_bags.frames import state_layout
from hamr_bags.topics import JOINT_STATE
from hamr_bags.writer import BagWriter
from hamr_description.names import AXES, Topic, joint_signs

#: Topic prefix -> state.
TOPICS = {"/measured": "target", "/retuned": "retuned", "/simulated": "after"}


def write_overlay(pictures: Mapping[str, Mapping[str, np.ndarray]], path: Path) -> None:
    """Writes /measured, /retuned and /simulated/joint_states (sensor_msgs/JointState, rad, in the robot's signs); replaces an older bag.

    Args:
        pictures: arrays of `show.show` by leg.
    """
    if path.exists():
        rmtree(path)
    lengths: dict[int, list[str]] = {}
    for leg, arrays in pictures.items():
        lengths.setdefault(len(arrays["time"]), []).append(leg)
    with BagWriter(path) as bag:
        for legs in lengths.values():
            joints = tuple(f"{leg}_{axis}" for leg in legs for axis in AXES)
            signs = np.concatenate([joint_signs(leg) for leg in legs])
            times = np.round(pictures[legs[0]]["time"] * NS).astype(np.int64)
            series = {
                prefix + Topic.JOINT_STATES: _messages(
                    joints, times, signs * np.hstack([pictures[leg][state][:, : len(AXES)] for leg in legs])
                )
                for prefix, state in TOPICS.items()
            }
            for k, stamp in enumerate(times.tolist()):
                for topic, messages in series.items():
                    bag.write(topic, messages[k], stamp, JOINT_STATE)


def _messages(joints: tuple[str, ...], times: np.ndarray, angles: np.ndarray) -> list[bytes]:
    layout = state_layout(joints, ("position",))
    block = layout.blank(len(times))
    numbers = layout.views(block, len(times))
    numbers["stamp"][:] = np.stack(np.divmod(times, NS), axis=-1)
    numbers["position"][:] = angles
    raw = block.tobytes()
    return [raw[i : i + layout.size] for i in range(0, len(raw), layout.size)]
