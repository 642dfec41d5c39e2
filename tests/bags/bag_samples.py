"""Small bags from smooth signals, made in two independent ways: by this project's writer and by rosbags'."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from hamr_bags.frames import SERVO_FIELDS, servo_frame
from hamr_bags.recorder import Recorder
from hamr_bags.run_info import RunInfo
from hamr_bags.topics import SERVO
from hamr_description.names import ACTUATORS, JOINTS, Topic

STORE = get_typestore(Stores.ROS2_JAZZY)
TYPES = STORE.types
STRING = "std_msgs/msg/String"
TRAJECTORY = "trajectory_msgs/msg/JointTrajectory"
PERIOD_NS = 4_000_000


def message(msgtype: str, *values: object) -> object:
    return TYPES[msgtype](*values)


def cdr(msgtype: str, *values: object) -> bytes:
    return bytes(STORE.serialize_cdr(message(msgtype, *values), msgtype))


def header(ns: int, frame_id: str = "") -> object:
    return message("std_msgs/msg/Header", message("builtin_interfaces/msg/Time", *divmod(ns, 10**9)), frame_id)


def trajectory(ns: int, names: Iterable[str], since: np.ndarray, fields: dict[str, np.ndarray], frame_id: str = "") -> bytes:
    """A JointTrajectory as rosbags writes it; fields (points, joints), since (points,) ns."""
    empty = np.zeros(0)
    order = ("positions", "velocities", "accelerations", "effort")
    points = [
        message(
            "trajectory_msgs/msg/JointTrajectoryPoint",
            *(np.ascontiguousarray(fields[name][i]) if name in fields else empty for name in order),
            message("builtin_interfaces/msg/Duration", *divmod(int(since[i]), 10**9)),
        )
        for i in range(len(since))
    ]
    return cdr(TRAJECTORY, header(ns, frame_id), list(names), points)


@dataclass(frozen=True)
class Run:
    """True numbers of a synthetic run: time (n,) s from the start, and (n, 8) arrays by topic and field."""

    frames: int
    per_frame: int
    start_ns: int
    numbers: dict[str, dict[str, np.ndarray]]

    @property
    def time(self) -> np.ndarray:
        return (self.start_ns + np.arange(self.frames * self.per_frame) * (PERIOD_NS // self.per_frame)) / 1e9

    def frame(self, topic: str, k: int) -> dict[str, np.ndarray]:
        rows = slice(k * self.per_frame, (k + 1) * self.per_frame)
        return {field: array[rows] for field, array in self.numbers[topic].items()}

    def info(self, **values: object) -> RunInfo:
        return RunInfo.of_simulation(environment="suspended", samples_per_frame=self.per_frame, backend="full", engine="kernel", **values)


def run(frames: int = 12, per_frame: int = 4, start_ns: int = 3_000_000_000) -> Run:
    t = np.arange(frames * per_frame)[:, None] / (250 * per_frame)
    phase = np.arange(8)

    def wave(amplitude: float, hertz: float) -> np.ndarray:
        return amplitude * np.sin(2 * np.pi * hertz * t + phase)

    numbers = {
        Topic.SERVO_JOINTS: {"positions": wave(0.2, 9), "velocities": wave(11, 9), "accelerations": wave(600, 9), "effort": wave(1e-4, 9)},
        Topic.SERVO_ACTUATORS: {"positions": wave(1e-4, 9), "velocities": wave(6e-3, 9), "effort": wave(0.1, 9)},
        Topic.SERVO_VOLTAGES: {"effort": 112.5 + wave(60, 9)},
    }
    return Run(frames, per_frame, start_ns, numbers)


def record(out: Path, source: Run, *, order: Callable[[str], Iterable[int]] | None = None, info: RunInfo | None = None) -> Path:
    """Record a run with this project's recorder; `order(topic)` gives the frames to write, default all in order."""
    frames = {topic: servo_frame(topic, source.per_frame) for topic in SERVO}
    with Recorder(out) as recorder:
        recorder.write(Topic.RUN_INFO, cdr(STRING, (info or source.info()).to_json()))
        plan = [(topic, k, slot) for topic in SERVO for slot, k in enumerate(order(topic) if order else range(source.frames))]
        for topic, k, slot in sorted(plan, key=lambda item: item[2]):
            frame = frames[topic]
            frame.stamp(source.start_ns + k * PERIOD_NS)
            for field in SERVO_FIELDS[topic]:
                frame.numbers[field][:] = source.frame(topic, k)[field]
            recorder.write(topic, bytes(frame), source.start_ns + slot * PERIOD_NS)
    return out


def foreign(
    out: Path,
    source: Run,
    *,
    columns: Iterable[int] = range(8),
    plugin: StoragePlugin = StoragePlugin.MCAP,
    topics: Iterable[str] = SERVO,
    fields: Callable[[str, str, np.ndarray], np.ndarray | None] = lambda topic, field, values: values,
    info: str | None = None,
) -> Path:
    """The same run as another recorder would store it: rosbags' writer, joints in another order, `fields` may alter or drop one."""
    columns = list(columns)
    since = np.arange(source.per_frame) * (PERIOD_NS // source.per_frame)
    writer = Writer(out, version=9, storage_plugin=plugin)
    if plugin == StoragePlugin.MCAP:
        writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    with writer:
        if info is not None:
            connection = writer.add_connection(Topic.RUN_INFO, STRING, typestore=STORE)
            writer.write(connection, source.start_ns, cdr(STRING, info))
        for topic in topics:
            names = ACTUATORS if topic != Topic.SERVO_JOINTS else JOINTS
            connection = writer.add_connection(topic, TRAJECTORY, typestore=STORE)
            for k in range(source.frames):
                numbers = {field: fields(topic, field, values) for field, values in source.frame(topic, k).items()}
                numbers = {field: values[:, columns] for field, values in numbers.items() if values is not None}
                stamp = source.start_ns + k * PERIOD_NS
                raw = trajectory(stamp, [names[j] for j in columns], since, numbers, frame_id="robot")
                writer.write(connection, stamp + 1_234_567, raw)
    return out
