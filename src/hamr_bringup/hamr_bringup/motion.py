"""How the robot moved in a bag: hip angles, and the base pose where the bag has one."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from hamr_bags.bag import open_bag
from hamr_bags.reader import base_pose, joint_states, load
from hamr_bags.recording import Pose
from hamr_description.names import Topic
from hamr_description.units import length_from_si, quaternion_from_ros


@dataclass(frozen=True, slots=True)
class Motion:
    """Attributes:
    time: (n,) s, increasing.
    angles: (n, 8) rad, canonical joint order.
    base: pose at its own times; None if the bag has none, for a robot that hangs.
    """

    time: np.ndarray
    angles: np.ndarray
    base: Pose | None

    def angles_at(self, time: np.ndarray) -> np.ndarray:
        """Hip angles (m, 8) rad at times (m,) s, linear between samples."""
        return np.stack([np.interp(time, self.time, column) for column in self.angles.T], -1)

    def base_at(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Base position (m, 3) mm, linear, and quaternion (m, 4) wxyz, along the shortest turn, at times (m,) s."""
        position = np.stack([np.interp(time, self.base.time, column) for column in self.base.position.T], -1)
        turns = Slerp(self.base.time, Rotation.from_quat(self.base.quaternion))
        quaternion = turns(np.clip(time, self.base.time[0], self.base.time[-1])).as_quat()
        return length_from_si(position), quaternion_from_ros(quaternion)


def read_motion(bag: Path) -> Motion:
    """Angles of /joint_states, else of the servo samples; pose of /odom. BagError if there are no angles."""
    with open_bag(bag) as opened:
        counts = opened.counts
    if counts.get(Topic.JOINT_STATES):
        time, angles = joint_states(bag)
    else:
        samples = load(bag, measured=())
        time, angles = samples.time, samples.angles
    return Motion(time, angles, base_pose(bag) if counts.get(Topic.ODOM) else None)
