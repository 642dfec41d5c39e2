"""A simulated bag as an instrumented robot would have given it: no simulation-only fields, encoder noise on what is left."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from hamr_description.errors import BagError
from hamr_description.names import Topic
from hamr_description.numbers import value
from hamr_description.units import length_to_si

from .bag import open_bag
from .cdr import NS, string, text
from .decode import Decoder
from .frames import SERVO_NAMES, odometry_layout, trajectory_layout
from .layout import Frame
from .run_info import RunInfo
from .topics import ODOMETRY, SERVO, TRAJECTORY
from .writer import BagWriter

#: Encoder noise, standard deviation as a share of the stroke.
NOISE = 1e-3
#: Noise of motion capture at that, standard deviations of position in m and of orientation about each axis in rad.
POSITION_NOISE, ORIENTATION_NOISE = 5e-5, 2e-3
#: Copied as they are: the clock, what was commanded, what the robot is.
_COPIED = (Topic.CLOCK, Topic.LEG_TARGETS, Topic.CMD_VEL, Topic.ROBOT_DESCRIPTION)
#: What stays of each servo topic; a simulation's rates are exact, so they go too.
_KEPT = {Topic.SERVO_JOINTS: "positions", Topic.SERVO_ACTUATORS: "positions", Topic.SERVO_VOLTAGES: "effort"}


def strokes() -> dict[str, float]:
    """Full stroke of the encoders: the range of target angles, +-25 degrees, in rad; between the end stops, +-0.3 mm, in m."""
    return {
        Topic.SERVO_JOINTS: 2 * value("controller.target_limit"),
        Topic.SERVO_ACTUATORS: 2 * length_to_si(value("actuator.stop")),
    }


def as_measured(bag: str | Path, out: str | Path, *, noise: float = NOISE, seed: int = 0) -> Path:
    """Write the measured channels of a bag to a new one.

    Kept: time, drive voltages (exact: they are commanded), hip angles and tip deflections, both with white Gaussian noise of
    standard deviation `noise` times the stroke (`strokes`), independent per sample and channel; clock, targets, commands,
    URDF; of /run_info rates, units and environment; of a robot on the ground the pose in /odom as motion capture gives it
    (0.05 mm and 2 mrad at the default noise, in proportion otherwise). Left out: rates, effort, force, acceleration, twist, and the
    topics /joint_states and /diagnostics. Equal seed and bag give equal numbers.

    Args:
        bag: simulated bag.
        out: folder to make.
        noise: share of the stroke, 0 to 1.
        seed: of the noise.

    Returns:
        The new bag. BagError if the bag does not fit, or `out` exists.
    """
    if not 0 <= noise <= 1:
        raise BagError(f"noise is {noise}; give it as a share of the stroke, 0 to 1.")
    with open_bag(bag) as opened:
        for topic in SERVO:
            opened.require(topic)
        sensors = {topic: _Sensor(topic, noise * strokes().get(topic, 0.0), [seed, i]) for i, topic in enumerate(SERVO)}
        if RunInfo.conditions(text(opened.raws(Topic.RUN_INFO)[1][-1])).environment == "ground":
            sensors[Topic.ODOM] = _Camera(noise / NOISE, [seed, len(SERVO)])
        with BagWriter(out) as writer:
            for message in opened.messages((*sensors, *_COPIED, Topic.RUN_INFO)):
                raw = message.raw
                if message.topic in sensors:
                    raw = sensors[message.topic](raw)
                elif message.topic == Topic.RUN_INFO:
                    info = replace(RunInfo.conditions(text(raw)), as_measured={"noise": noise, "seed": seed})
                    raw = string(info.to_json())
                writer.write(message.topic, raw, message.log_ns, message.msgtype)
    return writer.path


class _Sensor:
    """Rewrites the frames of one servo topic as its sensor would have given them."""

    def __init__(self, topic: str, deviation: float, seed: list[int]) -> None:
        self._topic, self._names, self._field = topic, SERVO_NAMES[topic], _KEPT[topic]
        self._deviation = deviation
        self._random = np.random.default_rng(seed)
        self._read = Decoder(TRAJECTORY, self._names)
        self._frame: Frame | None = None

    def __call__(self, raw: bytes) -> bytes:
        numbers = self._read(raw)
        if self._field not in numbers:
            raise BagError(f"{self._topic} has a message without '{self._field}'; record it.")
        values = numbers[self._field]
        if self._frame is None or self._frame.numbers[self._field].shape != values.shape:
            self._frame = Frame(trajectory_layout(self._names, (self._field,), len(values)))
        self._frame.stamp(int(numbers["stamp"]))
        self._frame.numbers["time_from_start"][:] = np.stack(np.divmod(numbers["time_from_start"], NS), axis=-1)
        self._frame.numbers[self._field][:] = values + self._random.normal(0.0, self._deviation, values.shape)
        return bytes(self._frame)


class _Camera:
    """Rewrites /odom as motion capture would have given it: the pose with noise, and no twist, which its covariance says (-1)."""

    def __init__(self, scatter: float, seed: list[int]) -> None:
        self._deviations = np.repeat(np.multiply(scatter, (POSITION_NOISE, ORIENTATION_NOISE)), 3)
        self._random = np.random.default_rng(seed)
        self._read, self._frame = Decoder(ODOMETRY, ()), Frame(odometry_layout())
        self._frame.numbers["twist_covariance"][0] = -1.0

    def __call__(self, raw: bytes) -> bytes:
        numbers, (moved, turned) = self._read(raw), self._random.normal(0.0, self._deviations).reshape(2, 3)
        self._frame.stamp(int(numbers["stamp"]))
        self._frame.numbers["position"][:] = numbers["position"] + moved
        seen = Rotation.from_quat(numbers["orientation"]) * Rotation.from_rotvec(turned)
        self._frame.numbers["orientation"][:] = seen.as_quat()
        return bytes(self._frame)
