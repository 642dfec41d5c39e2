"""What a bag measured: time, drive voltages and sensor channels, of whatever legs it holds; lost samples are NaN."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hamr_bags.align import stitch
from hamr_bags.bag import Bag, open_bag
from hamr_bags.cdr import NS, deserialize, text
from hamr_bags.decode import decode_all
from hamr_bags.run_info import RunInfo
from hamr_bags.topics import TRAJECTORY
from hamr_description.errors import BagError
from hamr_description.names import AXES, JOINTS, LEGS, Topic

JITTER = 0.25  # of a sample, between a stamp and an even clock
FIELDS = {Topic.SERVO_VOLTAGES: "effort", Topic.SERVO_JOINTS: "positions", Topic.SERVO_ACTUATORS: "positions"}


@dataclass(frozen=True)
class Samples:
    """Even samples of one run, SI, one column for each of `joints`.

    Attributes:
        joints: canonical names, both of every leg. start: s, of the first sample. sample_hz: of the sensors.
        voltages: (n * k, m) V, k for each reading. angles: (n, m) rad and deflections: (n, m) m or None; NaN where lost.
    """

    joints: tuple[str, ...]
    start: float
    sample_hz: float
    voltages: np.ndarray
    angles: np.ndarray
    deflections: np.ndarray | None

    @property
    def legs(self) -> tuple[str, ...]:
        """The legs measured."""
        return tuple(leg for leg in LEGS if f"{leg}_{AXES[0]}" in self.joints)

    @property
    def time(self) -> np.ndarray:
        """(n,) s."""
        return self.start + np.arange(len(self.angles)) / self.sample_hz


def environment(bag: str | Path) -> str:
    """Where a bag was recorded: "ground" or "suspended", which also stands for a bag that does not say.

    Raises:
        BagError: missing or damaged bag.
    """
    with open_bag(bag) as opened:
        info = _conditions(opened)
    return info.environment if info is not None else "suspended"


def read(bag: str | Path) -> Samples:
    """Reads what a bag measured of suspended legs; effort, force, acceleration and most of /run_info are never looked at.

    Raises:
        BagError: missing, damaged or empty bag, no whole leg in it, uneven or different clocks, a run on the ground.
    """
    with open_bag(bag) as opened:
        info = _conditions(opened)
        if info is not None and info.environment == "ground":
            raise BagError(f"{bag} was recorded on the ground, the others with the robot hung up; study the two kinds apart.")
        columns = {topic: _channel(opened, topic) for topic in FIELDS if topic != Topic.SERVO_ACTUATORS or opened.counts.get(topic)}
    joints = _joints(bag, columns)
    chosen = {topic: (time, np.stack([series[joint] for joint in joints], 1))
              for topic, (time, series) in columns.items() if all(joint in series for joint in joints)}  # fmt: skip
    time = chosen[Topic.SERVO_JOINTS][0]
    hz = float(info.sample_hz) if info else NS / float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    sensed = [topic for topic in chosen if topic != Topic.SERVO_VOLTAGES]
    first, last = (pick(chosen[topic][0][at] for topic in chosen) for at, pick in ((0, max), (-1, min)))
    count = int((last - first) * hz / NS + 0.5) + 1
    if count < 2:
        raise BagError(f"{bag}: its topics have no time in common; record them in one run with one clock.")
    readings = {topic: _even(bag, topic, *chosen[topic], first, hz, count) for topic in sensed}
    volts = _held(bag, *chosen[Topic.SERVO_VOLTAGES], first, hz, count)
    return Samples(joints, first / NS, hz, volts, readings[Topic.SERVO_JOINTS], readings.get(Topic.SERVO_ACTUATORS))


def _conditions(opened: Bag) -> RunInfo | None:
    return RunInfo.conditions(text(opened.raws(Topic.RUN_INFO)[1][-1])) if opened.counts.get(Topic.RUN_INFO) else None


def _channel(opened: Bag, topic: str) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Times (n,) ns, and (n,) values of each joint that the topic holds."""
    raws = opened.raws(topic)[1]
    names = tuple(deserialize(raws[0], TRAJECTORY).joint_names)
    try:
        time, numbers = stitch((part for _, part in decode_all(raws, TRAJECTORY, names)), [FIELDS[topic]])
    except BagError as error:
        raise BagError(f"{opened.path}, {topic}: {error}") from None
    return time, {name.removesuffix("_actuator"): column for name, column in zip(names, numbers[FIELDS[topic]].T, strict=True)}


def _joints(bag: str | Path, columns: dict) -> tuple[str, ...]:
    """Joints of the legs that are whole."""
    driven, seen = (set(columns[topic][1]) for topic in (Topic.SERVO_VOLTAGES, Topic.SERVO_JOINTS))
    if unknown := sorted((driven | seen) - set(JOINTS)):
        raise BagError(f"{bag} has the unknown joint {unknown[0]}; name joints as in {', '.join(JOINTS)}.")
    whole = [leg for leg in LEGS if all(f"{leg}_{axis}" in driven & seen for axis in AXES)]
    if not whole:
        raise BagError(f"{bag} holds no leg with voltages and angles of both its joints; record {Topic.SERVO_VOLTAGES} and "
                       f"{Topic.SERVO_JOINTS} of whole legs.")  # fmt: skip
    return tuple(f"{leg}_{axis}" for leg in whole for axis in AXES)


def _even(bag: str | Path, topic: str, time: np.ndarray, values: np.ndarray, first: int, hz: float, count: int) -> np.ndarray:
    """(count, m) values at even times, NaN where lost."""
    at = (time - first) * hz / NS
    index = np.round(at).astype(int)
    inside = (index >= 0) & (index < count)
    if np.median(np.abs(at - index)[inside]) > JITTER:
        raise BagError(f"{bag}, {topic}: stamps do not follow an even clock of {hz:g} Hz; stamp samples by the clock that takes them.")
    even = np.full((count, values.shape[1]), np.nan)
    even[index[inside]] = values[inside]
    return even


def _held(bag: str | Path, time: np.ndarray, volts: np.ndarray, first: int, hz: float, count: int) -> np.ndarray:
    """(count * k, m) voltages, each held until the next; k of them for each reading where they were recorded faster."""
    step = float(np.median(np.diff(time))) if len(time) > 1 else NS / hz
    per = max(1, round(NS / hz / step))
    at = first + np.arange(count * per) * (NS / hz / per)
    latest = np.searchsorted(time, at + 0.25 * step, side="right") - 1
    if latest[0] < 0 or (at - time[latest]).max() > 2.5 * step:
        when = at[int(np.argmax(at - time[latest]))] / NS
        raise BagError(f"{bag}: the voltages are missing about {when:.3f} s; without them the model cannot follow, cut that part out.")
    return volts[latest]
