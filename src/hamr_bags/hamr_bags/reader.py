"""Bag -> Recording. Only what counts as measured is read: time, voltages and the declared sensor channels.

Effort, force and acceleration, and every /run_info field but rates, units and environment, never reach a Recording
unless `truth=True` asks for the simulation's own.
"""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

import numpy as np

from hamr_description.errors import BagError
from hamr_description.names import JOINTS, Topic
from hamr_description.rates import TARGET_HZ

from .align import common, stitch
from .bag import Bag, open_bag
from .cdr import NS, text
from .decode import Decoder, decode_all
from .frames import SERVO_NAMES
from .layout import Numbers
from .recording import Pose, Recording
from .run_info import RunInfo
from .topics import TYPES

#: Channels of a Recording: the topic and the field they come from.
CHANNELS = {
    "voltages": (Topic.SERVO_VOLTAGES, "effort"),
    "angles": (Topic.SERVO_JOINTS, "positions"),
    "deflections": (Topic.SERVO_ACTUATORS, "positions"),
    "rates": (Topic.SERVO_JOINTS, "velocities"),
    "deflection_rates": (Topic.SERVO_ACTUATORS, "velocities"),
    "torque": (Topic.SERVO_JOINTS, "effort"),
    "acceleration": (Topic.SERVO_JOINTS, "accelerations"),
    "force": (Topic.SERVO_ACTUATORS, "effort"),
}
#: Sensor channels of the robot; whatever is declared besides, time, voltages and hip angles are always read.
MEASURED = ("angles", "deflections")
MEASURABLE = (*MEASURED, "rates", "deflection_rates", "pose")
TRUTH = ("rates", "deflection_rates", "torque", "acceleration", "force")


def load(bag: str | Path, *, measured: Collection[str] = MEASURED, truth: bool = False) -> Recording:
    """Read the samples of a bag, from any ROS 2 recorder, joints in any order.

    Args:
        bag: bag folder, or .mcap or .db3 file.
        measured: declared sensor channels, of MEASURABLE; the others stay None.
        truth: also the simulation's own rates, torque, acceleration and force. Not for learning or identification.

    Returns:
        The rows at which every channel has a sample and the voltage is known (held from its latest sample). Messages are
        put in order by their stamps, repeated samples are dropped, gaps stay (`Recording.pieces`).

    Raises:
        BagError: missing, damaged, foreign or empty bag; a missing topic, channel or joint; NaN or infinity.
    """
    if unknown := [name for name in measured if name not in MEASURABLE]:
        raise BagError(f"'{unknown[0]}' is no sensor channel; declare some of {', '.join(MEASURABLE)}.")
    wanted = {"voltages", "angles", *measured, *(TRUTH if truth else ())}
    channels = {name: place for name, place in CHANNELS.items() if name in wanted}
    with open_bag(bag) as opened:
        environment, sample_hz = _conditions(opened)
        samples = {topic: _read(opened, topic, [f for t, f in channels.values() if t == topic]) for topic, _ in channels.values()}
        pose = _pose(opened) if "pose" in wanted else None
    times = {topic: time for topic, (time, _) in samples.items()}
    time, rows = _common(opened.path, times)
    columns = {name: samples[topic][1][field][rows[topic]] for name, (topic, field) in channels.items()}
    sample_hz = sample_hz or (NS / float(np.median(np.diff(time))) if len(time) > 1 else float(TARGET_HZ))
    return Recording(time=time / NS, environment=environment, sample_hz=sample_hz, pose=pose, **columns)


def channels(bag: str | Path) -> tuple[str, ...]:
    """Names of the channels that a bag holds, of CHANNELS and "pose", as its first messages have them."""
    with open_bag(bag) as opened:
        held = {"pose"} if opened.counts.get(Topic.ODOM) else set()
        for topic in {topic for topic, _ in CHANNELS.values()}:
            first = next(opened.messages([topic]), None)
            if first:
                numbers = Decoder(TYPES[topic], SERVO_NAMES[topic])(first.raw)
                held |= {name for name, place in CHANNELS.items() if place[0] == topic and place[1] in numbers}
    return tuple(name for name in (*CHANNELS, "pose") if name in held)


def joint_states(bag: str | Path, topic: str = Topic.JOINT_STATES) -> tuple[np.ndarray, np.ndarray]:
    """Hip angles of /joint_states, or targets of /leg_targets: time (m,) s, angles (m, 8) rad."""
    with open_bag(bag) as opened:
        time, numbers = _read(opened, topic, ["position"])
    return time / NS, numbers["position"]


def base_pose(bag: str | Path) -> Pose:
    """Base pose of /odom; BagError if the bag has none."""
    with open_bag(bag) as opened:
        return _pose(opened)


def run_info(bag: str | Path) -> RunInfo:
    """The whole /run_info; not for learning or identification. BagError if the bag has none."""
    with open_bag(bag) as opened:
        return RunInfo.from_json(text(opened.raws(Topic.RUN_INFO)[1][-1]))


def _conditions(opened: Bag) -> tuple[str, float]:
    if not opened.counts.get(Topic.RUN_INFO):
        return "", 0.0  # a robot's bag need not say; the stamps tell the rate
    info = RunInfo.conditions(text(opened.raws(Topic.RUN_INFO)[1][-1]))
    return info.environment, float(info.sample_hz)


def _pose(opened: Bag) -> Pose:
    time, numbers = _read(opened, Topic.ODOM, ["position", "orientation"])
    return Pose(time / NS, numbers["position"], numbers["orientation"])


def _read(opened: Bag, topic: str, fields: list[str]) -> tuple[np.ndarray, Numbers]:
    joints = SERVO_NAMES.get(topic, () if topic == Topic.ODOM else JOINTS)
    raws = opened.raws(topic)[1]
    try:
        return stitch((numbers for _, numbers in decode_all(raws, TYPES[topic], joints)), fields)
    except BagError as error:
        raise BagError(f"{opened.path}, {topic}: {error}") from None


def _common(path: Path, times: dict[str, np.ndarray]) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    sensed = {topic: time for topic, time in times.items() if topic != Topic.SERVO_VOLTAGES}
    try:
        return common(sensed, {Topic.SERVO_VOLTAGES: times[Topic.SERVO_VOLTAGES]})
    except BagError as error:
        raise BagError(f"{path}: {error}") from None
