"""Bags into arrays: exact, whoever recorded them, from the measured channels alone; and every bad bag named."""

from __future__ import annotations

import json
from dataclasses import fields

import numpy as np
import pytest
from bag_samples import ACTUATORS, STORE, STRING, TRAJECTORY, Run, cdr, foreign, header, message, record, run, trajectory
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2 import StoragePlugin, Writer

from hamr_bags.check import check
from hamr_bags.info import info
from hamr_bags.reader import MEASURABLE, base_pose, channels, joint_states, load, run_info
from hamr_bags.recording import digest
from hamr_bags.run_info import RunInfo
from hamr_bags.topics import SERVO
from hamr_bags.writer import BagWriter
from hamr_description.errors import BagError
from hamr_description.names import JOINTS, Topic

FOREVER = QosTime(9223372036, 854775807)
QOS = Qos(
    QosHistory.KEEP_LAST, 5, QosReliability.BEST_EFFORT, QosDurability.VOLATILE, FOREVER, FOREVER, QosLiveliness.AUTOMATIC, FOREVER, False
)  # fmt: skip
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


@pytest.fixture(scope="module")
def source() -> Run:
    return run()


@pytest.fixture(scope="module")
def bag(tmp_path_factory, source):
    return record(tmp_path_factory.mktemp("read") / "run", source)


@pytest.fixture(scope="module")
def expected(bag) -> str:
    return digest(load(bag))


def test_samples_come_back_exactly(bag, source):
    recording = load(bag, truth=True)
    assert np.array_equal(recording.time, source.time)
    assert recording.sample_hz == 1000
    assert recording.environment == "suspended"
    assert recording.pieces == [slice(0, len(source.time))]
    for name, (topic, field) in CHANNELS.items():
        assert np.array_equal(getattr(recording, name), source.numbers[topic][field])


def test_only_the_declared_channels_are_filled(bag):
    filled = {field.name for field in fields(load(bag)) if getattr(load(bag), field.name) is not None}
    assert filled == {"time", "voltages", "angles", "deflections", "environment", "sample_hz"}
    assert load(bag, measured=()).deflections is None
    assert load(bag, measured=("rates",)).rates is not None
    assert set(channels(bag)) == set(CHANNELS)


@given(columns=st.permutations(range(8)))
@settings(max_examples=5, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_another_recorder_and_order_of_joints_give_the_same_recording(columns, expected, source, tmp_path_factory):
    folder = tmp_path_factory.mktemp("foreign")
    assert digest(load(foreign(folder / "bag", source, columns=columns, info=source.info().to_json()))) == expected


def test_sqlite_and_bare_files_and_other_topic_orders_give_the_same_recording(expected, source, tmp_path):
    info = source.info().to_json()
    bags = [
        foreign(tmp_path / "a", source, plugin=StoragePlugin.SQLITE3, info=info),
        foreign(tmp_path / "b", source, topics=SERVO[::-1], info=info),
    ]
    for bag in bags:
        assert digest(load(bag)) == expected
        assert digest(load(next(file for file in bag.iterdir() if file.suffix in (".mcap", ".db3")))) == expected


def test_a_bag_without_run_info_tells_its_rate_by_its_stamps(source, tmp_path):
    recording = load(foreign(tmp_path / "bag", source))
    assert recording.sample_hz == pytest.approx(1000)
    assert recording.environment == ""
    assert np.array_equal(recording.angles, source.numbers[Topic.SERVO_JOINTS]["positions"])


def test_nothing_but_the_measured_channels_is_read(expected, source, tmp_path):
    """Rates, effort of sensors, force, acceleration and the rest of /run_info scrambled: the same bytes come out."""
    random = np.random.default_rng(0)
    kept = {(Topic.SERVO_JOINTS, "positions"), (Topic.SERVO_ACTUATORS, "positions"), (Topic.SERVO_VOLTAGES, "effort")}

    def scramble(topic, field, values):
        return values if (topic, field) in kept else random.choice([np.nan, np.inf, 1e9, -3.0], values.shape)

    info = json.loads(source.info().to_json())
    conditions = ("environment", "samples_per_frame", "servo_hz", "target_hz", "units")
    scrambled = {key: value if key in conditions else ["nonsense", None, 3.5] for key, value in info.items()} | {"surprise": True}
    bag = foreign(tmp_path / "scrambled", source, fields=scramble, info=json.dumps(scrambled))
    assert digest(load(bag)) == expected
    bag = foreign(tmp_path / "absent", source, fields=lambda t, f, v: v if (t, f) in kept else None, info=source.info().to_json())
    assert digest(load(bag)) == expected
    with pytest.raises(BagError, match="without 'velocities'"):
        load(bag, measured=("rates",))


def write(out, frames: dict[str, list[tuple[int, int, np.ndarray]]]):
    """A bag of servo frames: topic -> (log time, stamp, values (n, 8) at 1 kHz)."""
    with BagWriter(out) as writer:
        for topic, rows in frames.items():
            field = "effort" if topic == Topic.SERVO_VOLTAGES else "positions"
            for logged, stamp, values in rows:
                names = JOINTS if topic == Topic.SERVO_JOINTS else ACTUATORS
                writer.write(topic, trajectory(stamp, names, np.arange(len(values)) * 1_000_000, {field: values}), logged)
    return out


def frames(ks, size=4, log=None):
    """Frame k of a signal that counts its own samples; `log` gives other log times."""
    counts = np.arange(400.0)[:, None] + np.arange(8) / 8
    return [(log[i] if log else k * 4_000_000, k * 4_000_000, counts[k * 4 : k * 4 + size]) for i, k in enumerate(ks)]


def test_shuffled_and_repeated_frames_are_put_in_order(tmp_path):
    order = [3, 0, 2, 2, 1, 3, 4]
    shuffled = frames(order, log=[i * 4_000_000 for i in range(7)])
    bag = write(tmp_path / "bag", {topic: shuffled for topic in SERVO})
    recording = load(bag)
    assert np.array_equal(recording.angles[:, 0], np.arange(20))
    assert recording.time == pytest.approx(np.arange(20) * 1e-3)


def test_gaps_split_a_recording_into_pieces(tmp_path):
    bag = write(tmp_path / "bag", {topic: frames([0, 1, 4, 5, 6]) for topic in SERVO})
    recording = load(bag)
    assert recording.pieces == [slice(0, 8), slice(8, 20)]
    assert [recording.angles[piece, 0].tolist() for piece in recording.pieces] == [list(range(8)), list(range(16, 28))]


def test_topics_that_began_and_ended_at_other_times_are_cut_to_what_they_share(tmp_path):
    bag = write(
        tmp_path / "bag",
        {Topic.SERVO_JOINTS: frames(range(6)), Topic.SERVO_ACTUATORS: frames(range(1, 9)), Topic.SERVO_VOLTAGES: frames(range(2, 5))},
    )
    recording = load(bag)
    assert np.array_equal(recording.angles[:, 0], np.arange(8, 20))
    assert np.array_equal(recording.angles, recording.deflections)
    assert np.array_equal(recording.angles, recording.voltages)


def test_slower_voltages_are_held_but_not_beyond_their_time(tmp_path):
    slow = frames(range(4), size=1)  # one voltage every 4 ms
    bag = write(
        tmp_path / "bag", {Topic.SERVO_JOINTS: frames(range(9)), Topic.SERVO_ACTUATORS: frames(range(9)), Topic.SERVO_VOLTAGES: slow}
    )
    recording = load(bag)
    assert np.array_equal(recording.voltages[:, 0], [0, 0, 0, 0, 4, 4, 4, 4, 8, 8, 8, 8, 12, 12, 12, 12])
    assert recording.time[-1] == pytest.approx(0.015)  # the next voltage was due at 0.016 s


def test_voltages_are_not_held_over_a_gap(tmp_path):
    lost = [0, 1, 4, 5]
    bag = write(
        tmp_path / "bag",
        {Topic.SERVO_JOINTS: frames(range(6)), Topic.SERVO_ACTUATORS: frames(range(6)), Topic.SERVO_VOLTAGES: frames(lost)},
    )
    recording = load(bag)
    assert np.array_equal(recording.voltages[:, 0], [*range(8), *range(16, 24)])
    assert np.array_equal(recording.angles, recording.voltages)


def test_digest_is_of_the_numbers(bag, expected):
    assert digest(load(bag, measured=("angles", "deflections"))) == expected
    assert digest(load(bag, measured=("angles",))) != expected
    assert digest(load(bag, truth=True)) != expected


def test_pose_targets_and_run_info(tmp_path, source):
    geometry, covariance = "geometry_msgs/msg/", np.zeros(36)
    zero = message(f"{geometry}Vector3", 0.0, 0.0, 0.0)
    record(tmp_path / "bag", source)
    with BagWriter(tmp_path / "with_pose") as writer:
        for k in range(source.frames):
            stamp = source.start_ns + k * 4_000_000
            pose = message(
                f"{geometry}Pose", message(f"{geometry}Point", 0.1 * k, 0.2, 0.3), message(f"{geometry}Quaternion", 0.0, 0.6, 0.0, 0.8)
            )
            stamped = (header(stamp, "odom"), "base_link", message(f"{geometry}PoseWithCovariance", pose, covariance))
            twist = message(f"{geometry}TwistWithCovariance", message(f"{geometry}Twist", zero, zero), covariance)
            writer.write(Topic.ODOM, cdr("nav_msgs/msg/Odometry", *stamped, twist), stamp)
            targets = cdr("sensor_msgs/msg/JointState", header(stamp), list(JOINTS[::-1]), np.arange(8.0) + k, np.zeros(0), np.zeros(0))
            writer.write(Topic.LEG_TARGETS, targets, stamp)
            for topic in SERVO:
                names = JOINTS if topic == Topic.SERVO_JOINTS else ACTUATORS
                writer.write(topic, trajectory(stamp, names, np.arange(4) * 1_000_000, source.frame(topic, k)), stamp)
    pose = base_pose(tmp_path / "with_pose")
    assert np.array_equal(pose.position[:, 0], 0.1 * np.arange(source.frames))
    assert np.array_equal(pose.quaternion, np.tile([0.0, 0.6, 0.0, 0.8], (source.frames, 1)))
    assert pose.time[0] == source.start_ns / 1e9
    time, targets = joint_states(tmp_path / "with_pose", Topic.LEG_TARGETS)
    assert np.array_equal(targets, np.arange(7.0, -1, -1) + np.arange(source.frames)[:, None])
    assert len(time) == source.frames
    assert load(tmp_path / "with_pose").pose is None
    assert np.array_equal(load(tmp_path / "with_pose", measured=("pose",)).pose.position, pose.position)
    assert run_info(tmp_path / "bag") == source.info()
    with pytest.raises(BagError, match="holds no /odom"):
        base_pose(tmp_path / "bag")


def test_two_publishers_of_one_topic_are_one_topic(source, expected, tmp_path):
    """Recorders keep a channel per publisher; here odd and even frames come from two."""
    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        described = writer.add_connection(Topic.RUN_INFO, STRING, typestore=STORE)
        writer.write(described, 0, cdr(STRING, source.info().to_json()))
        for topic in SERVO:
            names = JOINTS if topic == Topic.SERVO_JOINTS else ACTUATORS
            profiles = [[], [QOS]]
            pair = [writer.add_connection(topic, TRAJECTORY, typestore=STORE, offered_qos_profiles=profile) for profile in profiles]
            for k in range(source.frames):
                stamp = source.start_ns + k * 4_000_000
                raw = trajectory(stamp, names, np.arange(4) * 1_000_000, source.frame(topic, k))
                writer.write(pair[k % 2], stamp, raw)
    assert digest(load(tmp_path / "bag")) == expected
    assert check(tmp_path / "bag").ok


class TestBadBags:
    def test_missing(self, tmp_path):
        with pytest.raises(BagError, match="There is no bag at"):
            load(tmp_path / "none")

    def test_not_a_bag(self, tmp_path):
        (tmp_path / "notes.txt").write_text("hello")
        for path in (tmp_path, tmp_path / "notes.txt"):
            with pytest.raises(BagError, match="is not a bag"):
                load(path)

    @pytest.mark.parametrize("content", [b"", b"hello", b"\x89MCAP0\r\n", b"\x89MCAP0\r\n" + b"\xff" * 100])
    def test_a_file_of_something_else(self, tmp_path, content):
        (tmp_path / "x.mcap").write_bytes(content)
        with pytest.raises(BagError, match=r"is damaged or cut off .*; run `hamr bag repair"):
            load(tmp_path / "x.mcap")

    def test_metadata_of_something_else(self, bag, tmp_path):
        for content in ("", "a: [", "rosbag2_bagfile_information: 3", "rosbag2_bagfile_information: {version: 99}"):
            (tmp_path / "metadata.yaml").write_text(content)
            with pytest.raises(BagError, match="is damaged or cut off"):
                load(tmp_path)

    def test_empty(self, tmp_path):
        with BagWriter(tmp_path / "bag"):
            pass
        with pytest.raises(BagError, match=r"holds no /servo/\w+ \(it holds nothing\)"):
            load(tmp_path / "bag")

    @pytest.mark.parametrize("topic", SERVO)
    def test_without_a_topic(self, source, tmp_path, topic):
        bag = foreign(tmp_path / "bag", source, topics=[other for other in SERVO if other != topic])
        with pytest.raises(BagError, match=f"holds no {topic} .*; record that topic too"):
            load(bag)

    def test_a_topic_of_another_type(self, tmp_path):
        with BagWriter(tmp_path / "bag") as writer:
            for topic in SERVO:
                writer.write(topic, cdr(STRING, "x"), 0, STRING)
        with pytest.raises(BagError, match=f"as {STRING}; it must be {TRAJECTORY}"):
            load(tmp_path / "bag")

    def test_a_joint_of_another_name(self, source, tmp_path):
        writer = Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP)
        with writer:
            for topic in SERVO:
                connection = writer.add_connection(topic, TRAJECTORY, typestore=STORE)
                writer.write(connection, 0, trajectory(0, ["knee", *JOINTS[1:]], np.zeros(1), {"positions": np.zeros((1, 8))}))
        with pytest.raises(BagError, match=r"/servo/\w+: A message lacks joint fl_swing"):
            load(tmp_path / "bag")

    @pytest.mark.parametrize("bad", [np.nan, np.inf])
    def test_not_a_number(self, tmp_path, bad):
        rows = {topic: frames(range(3)) for topic in SERVO}
        rows[Topic.SERVO_JOINTS][1][2][2, 5] = bad
        with pytest.raises(BagError, match="/servo/joints: 'positions' is not a finite number at 0.006000 s"):
            load(write(tmp_path / "bag", rows))

    def test_topics_of_different_clocks(self, tmp_path):
        rows = {topic: frames(range(3)) for topic in SERVO}
        rows[Topic.SERVO_ACTUATORS] = frames(range(50, 53))
        with pytest.raises(BagError, match="no sample time is common"):
            load(write(tmp_path / "bag", rows))

    def test_frames_without_points(self, tmp_path):
        rows = {topic: frames(range(3), size=0) for topic in SERVO}
        with pytest.raises(BagError, match="hold no samples"):
            load(write(tmp_path / "bag", rows))

    def test_an_unknown_channel(self, bag):
        with pytest.raises(BagError, match=f"'torque' is no sensor channel; declare some of {', '.join(MEASURABLE)}"):
            load(bag, measured=("torque",))

    @given(cut=st.integers(0, 10**6))
    @settings(max_examples=40, deadline=None)
    def test_cut_anywhere(self, bag, tmp_path_factory, cut):
        whole = next(bag.glob("*.mcap")).read_bytes()
        file = tmp_path_factory.mktemp("cut") / "cut.mcap"
        file.write_bytes(whole[: cut % len(whole)])
        with pytest.raises(BagError, match="hamr bag repair"):
            load(file)

    @given(place=st.integers(0, 10**6), content=st.binary(min_size=1, max_size=12))
    @settings(max_examples=60, deadline=None)
    def test_damaged_anywhere_is_read_or_refused(self, bag, tmp_path_factory, place, content):
        whole = bytearray(next(bag.glob("*.mcap")).read_bytes())
        place %= len(whole)
        whole[place : place + len(content)] = content
        file = tmp_path_factory.mktemp("damaged") / "damaged.mcap"
        file.write_bytes(whole)
        read_or_refuse(file)

    @given(topic=st.sampled_from(SERVO), place=st.integers(0, 10**4), content=st.binary(min_size=1, max_size=12), cut=st.booleans())
    @settings(max_examples=60, deadline=None)
    def test_damaged_messages_are_read_or_refused(self, source, tmp_path_factory, topic, place, content, cut):
        out = tmp_path_factory.mktemp("messages") / "bag"
        with BagWriter(out) as writer:
            for name in SERVO:
                names = JOINTS if name == Topic.SERVO_JOINTS else ACTUATORS
                for k in range(3):
                    raw = bytearray(trajectory(k * 4_000_000, names, np.arange(4) * 1_000_000, source.frame(name, k)))
                    if (name, k) == (topic, 1):
                        start = place % len(raw)
                        raw[start : len(raw) if cut else start + len(content)] = content
                    writer.write(name, bytes(raw), k * 4_000_000)
        read_or_refuse(out)


def read_or_refuse(bag):
    """Every way to look at a bag either works or says one sentence."""
    for look in (load, check, info, channels):
        try:
            look(bag)
        except BagError as error:
            assert "\n" not in str(error)


class TestRunInfo:
    def test_round_trip(self, source):
        info = source.info(excitation={"kind": "noise", "seconds": 12.0}, effects=[{"effect": "backlash"}], seed=4)
        assert RunInfo.from_json(info.to_json()) == info
        assert info.sample_hz == 1000
        assert len(info.parameters_hash) == 16
        assert "numpy" in info.versions

    def test_a_robot_need_not_say_more_than_the_conditions(self):
        info = RunInfo.from_json('{"environment": "ground", "samples_per_frame": 10}')
        assert (info.backend, info.sample_hz, info.units["length"]) == ("", 2500, "m")

    @pytest.mark.parametrize(
        ("change", "said"),
        [
            ({"environment": "moon"}, "environment is 'moon'; it must be one of ground, suspended"),
            ({"samples_per_frame": "16"}, "'samples_per_frame' must be a int, but is '16'"),
            ({"samples_per_frame": True}, "must be a int, but is True"),
            ({"samples_per_frame": 0}, "must be positive"),
            ({"colour": "red"}, "unknown key 'colour'"),
            ({"units": {"length": "mm"}}, "unit of time is None"),
            ({"schema": 2}, "has schema 2, this program reads schema 1"),
        ],
    )
    def test_what_does_not_fit_is_named(self, source, change, said):
        with pytest.raises(BagError, match=said):
            RunInfo.from_json(json.dumps(json.loads(source.info().to_json()) | change))

    @pytest.mark.parametrize("text", ["", "[]", "{", "[" * 100_000])
    def test_what_is_no_object_is_refused(self, text):
        with pytest.raises(BagError, match="is not"):
            RunInfo.from_json(text)

    @pytest.mark.parametrize("key", ["environment", "samples_per_frame"])
    def test_what_is_missing_is_named(self, source, key):
        found = json.loads(source.info().to_json())
        del found[key]
        for read in (RunInfo.from_json, RunInfo.conditions):
            with pytest.raises(BagError, match=f"lacks '{key}'"):
                read(json.dumps(found))
