"""A walking case as encoders (4 kHz), recorded voltages and motion capture (250 Hz) give it; nothing in the bag tells what is hidden."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from hamr_bags.cdr import NS, string
from hamr_bags.frames import odometry_layout, servo_frame
from hamr_bags.layout import Frame
from hamr_bags.run_info import CONDITIONS, RunInfo
from hamr_bags.writer import BagWriter
from hamr_description.names import JOINTS, Topic
from hamr_description.rates import TARGET_HZ
from hamr_description.units import length_to_si, quaternion_to_ros, time_to_si

from ..machine import TIME_SHIFT, change
from .case import GroundCase
from .machine import EVERY, SAMPLE_HZ, Walk

PER_FRAME = SAMPLE_HZ // TARGET_HZ


@dataclass(frozen=True, slots=True)
class Seen:
    """What the sensors give: volts (n, 8) V and angles (n, 8) rad at 4 kHz; at 250 Hz position (m, 3) m, orientation (m, 4) wxyz,
    linear (m, 3) m/s and angular (m, 3) rad/s in base_link."""

    volts: np.ndarray
    angles: np.ndarray
    position: np.ndarray
    orientation: np.ndarray
    linear: np.ndarray
    angular: np.ndarray


def seen(case: GroundCase, run: Walk) -> Seen:
    """A run with the case's sensor errors and noise.

    Motion capture sees poses; its rates are central differences of them, as its software gives them.
    """
    random = np.random.default_rng([case.seed, 1])
    qpos = _late(run.qpos, case.changes.get(TIME_SHIFT, 0.0))
    angles = qpos[:, 7:] * change(case.changes, "sensor_gain", JOINTS) + change(case.changes, "bias", JOINTS)
    poses = qpos[::PER_FRAME]
    position = length_to_si(poses[:, :3]) + case.position_noise * random.standard_normal((len(poses), 3))
    orientation = _turned(poses[:, 3:7], case.orientation_noise * random.standard_normal((len(poses), 3)))
    turn = 2.0 * np.sum(_products(orientation)[:, :, 1:] * np.gradient(orientation, axis=0)[:, :, None], axis=1)
    return Seen(
        volts=case.volts()[::EVERY],
        angles=angles + case.floors.angle * random.standard_normal(angles.shape),
        position=position,
        orientation=orientation,
        linear=_into(orientation, np.gradient(position, axis=0) * TARGET_HZ),
        angular=turn * TARGET_HZ,
    )


def write(case: GroundCase, folder: str | Path) -> dict:
    """Write the case's bag into a new folder; BagError if it exists.

    /servo/joints holds positions and /servo/voltages effort, 16 samples per message, /odom pose and twist; /run_info says rates, units
    and environment.

    Returns:
        The answer, JSON-able: the case.
    """
    found = seen(case, case.run())
    joints, volts = servo_frame(Topic.SERVO_JOINTS, PER_FRAME, ("positions",)), servo_frame(Topic.SERVO_VOLTAGES, PER_FRAME, ("effort",))
    odometry = Frame(odometry_layout())
    frames = {Topic.SERVO_JOINTS: joints, Topic.SERVO_VOLTAGES: volts, Topic.ODOM: odometry}
    info = RunInfo(environment="ground", samples_per_frame=PER_FRAME)
    with BagWriter(folder) as bag:
        bag.write(Topic.RUN_INFO, string(json.dumps({name: getattr(info, name) for name in CONDITIONS})), 0)
        for k in range(len(found.position)):
            rows = slice(k * PER_FRAME, (k + 1) * PER_FRAME)
            joints.numbers["positions"][:], volts.numbers["effort"][:] = found.angles[rows], found.volts[rows]
            odometry.numbers["position"][:], odometry.numbers["orientation"][:] = found.position[k], quaternion_to_ros(found.orientation[k])
            odometry.numbers["linear"][:], odometry.numbers["angular"][:] = found.linear[k], found.angular[k]
            for topic, frame in frames.items():
                frame.stamp(stamp := k * NS // TARGET_HZ)
                bag.write(topic, bytes(frame), stamp)
    return asdict(case)


def _late(qpos: np.ndarray, shift: float) -> np.ndarray:
    """Coordinates (n, 15) at 4 kHz, seen `shift` ms late, quaternions of length 1."""
    t = np.arange(len(qpos)) / SAMPLE_HZ
    late = np.stack([np.interp(t - time_to_si(shift), t, column) for column in qpos.T], axis=1) if shift else qpos.copy()
    late[:, 3:7] /= np.linalg.norm(late[:, 3:7], axis=1, keepdims=True)
    return late


def _products(q: np.ndarray) -> np.ndarray:
    """(n, 4, 4): columns are q times 1, i, j, k."""
    w, x, y, z = q.T
    return np.stack([np.stack(column, axis=1) for column in ((w, x, y, z), (-x, w, z, -y), (-y, -z, w, x), (-z, y, -x, w))], axis=2)


def _turned(q: np.ndarray, by: np.ndarray) -> np.ndarray:
    """Quaternions (n, 4) turned by small vectors (n, 3) in their own frames."""
    turned = q + 0.5 * np.einsum("nij,nj->ni", _products(q)[:, :, 1:], by)
    return turned / np.linalg.norm(turned, axis=1, keepdims=True)


def _into(q: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """World vectors (n, 3) in the frames of q (n, 4)."""
    w, r = q[:, :1], -q[:, 1:]
    return vectors + 2.0 * np.cross(r, np.cross(r, vectors) + w * vectors)
