"""How a robot walked in a bag: forward speed along its heading, yaw rate, whether it fell."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from hamr_bags.reader import base_pose
from hamr_description.numbers import value
from hamr_description.units import length_to_si

SETTLE_S = 0.3  # from rest to a steady gait: one episode of the paper
TILT_LIMIT = np.radians(45.0)


@dataclass(frozen=True, slots=True)
class Gait:
    """Attributes:
    time: (m,) s from the start. path: (m, 2) m, relative to the start, x along the first heading.
    height: (m,) m. forward: (m - 1,) m/s along the heading. yaw: (m,) rad, continuous. tilt: (m,) rad between body and world z.
    """

    time: np.ndarray
    path: np.ndarray
    height: np.ndarray
    forward: np.ndarray
    yaw: np.ndarray
    tilt: np.ndarray

    def summary(self) -> dict:
        """Figures after settling: speed_bl_s (body lengths per second, +- over 300 ms windows), yaw_rate_deg_s, fell, seconds."""
        steady = self.time[1:] > SETTLE_S
        speed = self.forward[steady] / length_to_si(value("robot.body_length"))
        duration = self.time[1:][steady]
        windows = [w.mean() for w in np.array_split(speed, max(1, round((duration[-1] - duration[0]) / SETTLE_S)))]
        belly = -length_to_si(value("robot.chassis_z_range")[0])
        return {
            "speed_bl_s": float(speed.mean()),
            "spread_bl_s": float(np.std(windows)),
            "yaw_rate_deg_s": float(np.degrees(np.diff(self.yaw)[steady].sum() / (duration[-1] - duration[0]))),
            "seconds": float(self.time[-1]),
            "fell": bool((self.height < belly).any() or (self.tilt > TILT_LIMIT).any()),
        }


def gait(bag: Path) -> Gait:
    """Reads /odom of a bag. BagError if it has none."""
    pose = base_pose(bag)
    turn = Rotation.from_quat(pose.quaternion)
    x_axis, z_axis = turn.apply([1.0, 0.0, 0.0]), turn.apply([0.0, 0.0, 1.0])
    yaw = np.unwrap(np.arctan2(x_axis[:, 1], x_axis[:, 0]))
    time = pose.time - pose.time[0]
    step = np.diff(pose.position[:, :2], axis=0) / np.diff(time)[:, None]
    middle = 0.5 * (yaw[1:] + yaw[:-1])
    forward = step[:, 0] * np.cos(middle) + step[:, 1] * np.sin(middle)
    c, s = np.cos(yaw[0]), np.sin(yaw[0])
    path = (pose.position[:, :2] - pose.position[0, :2]) @ np.array([[c, -s], [s, c]])
    return Gait(time, path, pose.position[:, 2], forward, yaw, np.arccos(np.clip(z_axis[:, 2], -1.0, 1.0)))
