"""Walks out of bags: time, voltages, hip angles and the pose of the chassis; nothing else is looked at."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from hamr_bags.bag import open_bag
from hamr_bags.cdr import text
from hamr_bags.reader import base_pose, load
from hamr_bags.recording import Recording
from hamr_bags.run_info import RunInfo
from hamr_description.errors import BagError
from hamr_description.names import Topic
from hamr_description.units import length_from_si, quaternion_from_ros, time_from_si

from .walk import Walk, joined

MOVED_MM = 5.0  # by a chassis that is not held
SHORTEST_S = 0.5  # of a stretch without lost samples that counts


def on_the_ground(bag: str | Path) -> bool:
    """Whether a bag is of a walking robot: it says so, or it says nothing and the chassis moved.

    Raises:
        BagError: the bag is missing, damaged or empty.
    """
    with open_bag(bag) as opened:
        if opened.counts.get(Topic.RUN_INFO):
            return RunInfo.conditions(text(opened.raws(Topic.RUN_INFO)[1][-1])).environment == "ground"
        seen = bool(opened.counts.get(Topic.ODOM))
    return seen and float(np.ptp(length_from_si(base_pose(bag).position), axis=0).max()) > MOVED_MM


def read(bags: Sequence[str | Path]) -> Walk:
    """All that bags from the ground measured of one robot.

    Raises:
        BagError: a bag is missing, damaged or empty, hung, holds no pose, or lost samples all the time.
    """
    return joined([stretch for bag in bags for stretch in _stretches(bag)])


def _stretches(bag: str | Path) -> list[Walk]:
    recording = load(bag, measured=("angles", "pose"))
    if recording.environment == "suspended":
        raise BagError(f"{bag} was recorded with the robot hung up; study its legs one by one instead.")
    found = [_walk(recording, piece) for piece in recording.pieces if (piece.stop - piece.start) / recording.sample_hz >= SHORTEST_S]
    if not found:
        raise BagError(f"{bag} holds no {SHORTEST_S:g} s without lost samples; record it again.")
    return found


def _walk(recording: Recording, piece: slice) -> Walk:
    """A stretch without lost samples; a pose counts at the sample nearest in time."""
    pose, time, hz = recording.pose, recording.time[piece], recording.sample_hz
    at = np.round((pose.time - time[0]) * hz).astype(int)
    inside = np.flatnonzero((at >= 0) & (at < len(time)))
    inside = inside[np.unique(at[inside], return_index=True)[1]]
    if len(inside) < 2:
        raise BagError(
            f"{Topic.ODOM} has no pose of the chassis between {time[0]:.2f} and {time[-1]:.2f} s; record it along with the joints."
        )
    quaternion = quaternion_from_ros(pose.quaternion[inside])
    return Walk(recording.voltages[piece], recording.angles[piece], time_from_si(1.0 / hz), at[inside],
                length_from_si(pose.position[inside]), quaternion / np.linalg.norm(quaternion, axis=1, keepdims=True))  # fmt: skip
