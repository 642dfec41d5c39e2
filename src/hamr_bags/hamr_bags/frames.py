"""The messages sent at 250 Hz: their layouts, and how a message's layout is told from the message itself.

A servo frame holds the samples of one 4 ms period. Its stamp is the time of its first sample; point i was taken
`time_from_start` later.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from hamr_description.errors import BagError
from hamr_description.names import ACTUATORS, BASE_FRAME, JOINTS, WORLD_FRAME, Topic
from hamr_description.rates import SUBSTEPS, TARGET_NS

from .cdr import NS, store
from .layout import Frame, Layout, Markers
from .topics import CLOCK, JOINT_STATE, ODOMETRY, TRAJECTORY

#: Samples per period that divide it evenly; 16 is 4 kHz, 80 is 20 kHz.
SAMPLES_PER_FRAME = tuple(n for n in range(1, SUBSTEPS + 1) if SUBSTEPS % n == 0)
POINT_FIELDS = ("positions", "velocities", "accelerations", "effort")
STATE_FIELDS = ("position", "velocity", "effort")
#: Fields of each servo topic (design: topics); velocities are rates, effort is N m, N and V.
SERVO_FIELDS = {
    Topic.SERVO_JOINTS: POINT_FIELDS,
    Topic.SERVO_ACTUATORS: ("positions", "velocities", "effort"),
    Topic.SERVO_VOLTAGES: ("effort",),
}
SERVO_NAMES = {Topic.SERVO_JOINTS: JOINTS, Topic.SERVO_ACTUATORS: ACTUATORS, Topic.SERVO_VOLTAGES: ACTUATORS}
_EMPTY = np.zeros(0)


def _new(msgtype: str, *values: object) -> object:
    return store().types[msgtype](*values)


def _header(stamp: np.ndarray, frame_id: str) -> object:
    return _new("std_msgs/msg/Header", _new("builtin_interfaces/msg/Time", *stamp.tolist()), frame_id)


@lru_cache(maxsize=64)
def trajectory_layout(names: tuple[str, ...], fields: tuple[str, ...], points: int, frame_id: str = "") -> Layout:
    """trajectory_msgs/JointTrajectory: `stamp` (2,), `time_from_start` (points, 2), each of `fields` (points, len(names))."""
    marks = Markers()
    stamp, since = marks.times(), marks.times(points)
    numbers = {field: marks.floats(points, len(names)) for field in fields}
    message = _new(
        TRAJECTORY,
        _header(stamp, frame_id),
        list(names),
        [
            _new(
                "trajectory_msgs/msg/JointTrajectoryPoint",
                *(numbers[field][i] if field in numbers else _EMPTY for field in POINT_FIELDS),
                _new("builtin_interfaces/msg/Duration", *since[i].tolist()),
            )
            for i in range(points)
        ],
    )
    return Layout(TRAJECTORY, message, {"stamp": stamp, "time_from_start": since, **numbers}, names)


@lru_cache(maxsize=64)
def state_layout(names: tuple[str, ...], fields: tuple[str, ...] = STATE_FIELDS, frame_id: str = "") -> Layout:
    """sensor_msgs/JointState: `stamp` (2,), each of `fields` (len(names),)."""
    marks = Markers()
    stamp = marks.times()
    numbers = {field: marks.floats(len(names)) for field in fields}
    values = (numbers.get(field, _EMPTY) for field in STATE_FIELDS)
    return Layout(JOINT_STATE, _new(JOINT_STATE, _header(stamp, frame_id), list(names), *values), {"stamp": stamp, **numbers}, names)


@lru_cache(maxsize=8)
def odometry_layout(frame_id: str = WORLD_FRAME, child: str = BASE_FRAME) -> Layout:
    """nav_msgs/Odometry: `stamp`, `position` (3,) m, `orientation` (4,) xyzw, `linear` (3,) m/s and `angular` (3,) rad/s
    in the child frame, `pose_covariance` and `twist_covariance` (36,)."""
    marks = Markers()
    stamp, sizes = marks.times(), (3, 4, 36, 3, 3, 36)
    position, orientation, pose_covariance, linear, angular, twist_covariance = (marks.floats(size) for size in sizes)
    point, quaternion = _new("geometry_msgs/msg/Point", *position), _new("geometry_msgs/msg/Quaternion", *orientation)
    vectors = [_new("geometry_msgs/msg/Vector3", *vector) for vector in (linear, angular)]
    message = _new(
        ODOMETRY,
        _header(stamp, frame_id),
        child,
        _new("geometry_msgs/msg/PoseWithCovariance", _new("geometry_msgs/msg/Pose", point, quaternion), pose_covariance),
        _new("geometry_msgs/msg/TwistWithCovariance", _new("geometry_msgs/msg/Twist", *vectors), twist_covariance),
    )
    numbers = {"position": position, "orientation": orientation, "linear": linear, "angular": angular}
    covariances = {"pose_covariance": pose_covariance, "twist_covariance": twist_covariance}
    return Layout(ODOMETRY, message, {"stamp": stamp, **numbers, **covariances})


@lru_cache(maxsize=1)
def clock_layout() -> Layout:
    """rosgraph_msgs/Clock: `stamp` (2,)."""
    stamp = Markers().times()
    return Layout(CLOCK, _new(CLOCK, _new("builtin_interfaces/msg/Time", *stamp.tolist())), {"stamp": stamp})


def servo_frame(topic: str, samples_per_frame: int, fields: tuple[str, ...] | None = None) -> Frame:
    """Frame of a servo topic with its `time_from_start` filled in.

    Args:
        topic: one of `topics.SERVO`.
        samples_per_frame: one of SAMPLES_PER_FRAME; every (80 / samples_per_frame)-th servo sample is kept.
        fields: those present; default SERVO_FIELDS[topic].
    """
    if samples_per_frame not in SAMPLES_PER_FRAME:
        choice = ", ".join(map(str, SAMPLES_PER_FRAME))
        raise BagError(f"samples_per_frame is {samples_per_frame}; choose a divisor of {SUBSTEPS}: {choice}.")
    frame = Frame(trajectory_layout(SERVO_NAMES[topic], fields or SERVO_FIELDS[topic], samples_per_frame))
    since = np.arange(samples_per_frame) * (TARGET_NS // samples_per_frame)
    frame.numbers["time_from_start"][:] = np.stack(np.divmod(since, NS), axis=-1)
    return frame


def layout_of(message: object) -> Layout:
    """Layout of a message object; BagError if its fields have uneven lengths."""
    kind = message.__msgtype__
    if kind == TRAJECTORY:
        names = tuple(message.joint_names)
        fields = _present(message.points[0] if message.points else None, POINT_FIELDS, len(names))
        for point in message.points:
            if _present(point, POINT_FIELDS, len(names)) != fields:
                raise BagError("A trajectory message has points with different fields; send the same fields in every point.")
        return trajectory_layout(names, fields, len(message.points), message.header.frame_id)
    if kind == JOINT_STATE:
        names = tuple(message.name)
        return state_layout(names, _present(message, STATE_FIELDS, len(names)), message.header.frame_id)
    if kind == ODOMETRY:
        return odometry_layout(message.header.frame_id, message.child_frame_id)
    if kind == CLOCK:
        return clock_layout()
    raise TypeError(f"no fixed layout for {kind}")


def _present(holder: object, fields: tuple[str, ...], length: int) -> tuple[str, ...]:
    sizes = {field: len(getattr(holder, field)) for field in fields} if holder is not None else {}
    for field, size in sizes.items():
        if size not in (0, length):
            raise BagError(f"A message names {length} joints but gives {size} values of '{field}'; give one value per joint.")
    return tuple(field for field, size in sizes.items() if size)
