"""The bytes of the fixed layouts against rosbags' serializer, and decoding whoever wrote them."""

from __future__ import annotations

import numpy as np
import pytest
from bag_samples import STORE, TRAJECTORY, cdr, header, message, trajectory
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from hamr_bags.cdr import deserialize, stamp_ns
from hamr_bags.decode import Decoder, decode_all
from hamr_bags.frames import (
    POINT_FIELDS,
    SERVO_FIELDS,
    STATE_FIELDS,
    clock_layout,
    odometry_layout,
    servo_frame,
    state_layout,
    trajectory_layout,
)
from hamr_bags.layout import Frame
from hamr_bags.topics import CLOCK, JOINT_STATE, ODOMETRY, SERVO
from hamr_description.errors import BagError
from hamr_description.names import ACTUATORS, JOINTS

stamps = st.integers(0, 2**31 * 10**9 - 1)
floats = st.floats(width=64)
frame_ids = st.text(max_size=9)
seeds = st.integers(0, 2**32)


@given(st.integers(0, 80), st.sets(st.sampled_from(POINT_FIELDS)), frame_ids, stamps, seeds)
def test_trajectory_bytes_are_those_of_rosbags(points, present, frame_id, stamp, seed):
    present = tuple(field for field in POINT_FIELDS if field in present)
    random = np.random.default_rng(seed)
    numbers = {field: random.standard_normal((points, 8)) for field in present}
    since = random.integers(0, 4_000_000, points)
    frame = Frame(trajectory_layout(JOINTS, present, points, frame_id))
    frame.stamp(stamp)
    frame.numbers["time_from_start"][:] = np.stack([since * 0, since], axis=-1)
    for field in present:
        frame.numbers[field][:] = numbers[field]
        assert frame.numbers[field].flags.aligned
    assert bytes(frame) == trajectory(stamp, JOINTS, since, numbers, frame_id)


@given(arrays(np.float64, (3, 8), elements=floats), st.sets(st.sampled_from(STATE_FIELDS)), frame_ids, stamps)
def test_joint_state_bytes_are_those_of_rosbags(values, present, frame_id, stamp):
    present = tuple(field for field in STATE_FIELDS if field in present)
    numbers = dict(zip(STATE_FIELDS, values, strict=True))
    frame = Frame(state_layout(ACTUATORS, present, frame_id))
    frame.stamp(stamp)
    for field in present:
        frame.numbers[field][:] = numbers[field]
    expected = [numbers[field] if field in present else np.zeros(0) for field in STATE_FIELDS]
    assert bytes(frame) == cdr(JOINT_STATE, header(stamp, frame_id), list(ACTUATORS), *expected)


@given(arrays(np.float64, 13, elements=floats), arrays(np.float64, (2, 36), elements=floats), stamps)
def test_odometry_and_clock_bytes_are_those_of_rosbags(state, covariances, stamp):
    frame, clock = Frame(odometry_layout()), Frame(clock_layout())
    frame.stamp(stamp)
    clock.stamp(stamp)
    for field, values in zip(("position", "orientation", "linear", "angular"), np.split(state, [3, 7, 10]), strict=True):
        frame.numbers[field][:] = values
    frame.numbers["pose_covariance"][:], frame.numbers["twist_covariance"][:] = covariances
    geometry = "geometry_msgs/msg/"
    pose = message(f"{geometry}Pose", message(f"{geometry}Point", *state[:3]), message(f"{geometry}Quaternion", *state[3:7]))
    twist = message(f"{geometry}Twist", message(f"{geometry}Vector3", *state[7:10]), message(f"{geometry}Vector3", *state[10:]))
    parts = message(f"{geometry}PoseWithCovariance", pose, covariances[0]), message(f"{geometry}TwistWithCovariance", twist, covariances[1])
    assert bytes(frame) == cdr(ODOMETRY, header(stamp, "odom"), "base_link", *parts)
    assert bytes(clock) == cdr(CLOCK, message("builtin_interfaces/msg/Time", *divmod(stamp, 10**9)))
    assert stamp_ns(bytes(frame), ODOMETRY) == stamp_ns(bytes(clock), CLOCK) == stamp


@pytest.mark.parametrize("topic", SERVO)
@pytest.mark.parametrize("samples", [1, 16, 80])
def test_servo_frames_space_their_samples_evenly_over_4_ms(topic, samples):
    frame = servo_frame(topic, samples)
    assert set(frame.numbers) == {"stamp", "time_from_start", *SERVO_FIELDS[topic]}
    points = STORE.deserialize_cdr(bytes(frame), TRAJECTORY).points
    assert [point.time_from_start.nanosec for point in points] == [i * (4_000_000 // samples) for i in range(samples)]


def test_servo_frames_refuse_an_uneven_number_of_samples():
    with pytest.raises(BagError, match="divisor of 80"):
        servo_frame(SERVO[0], 17)


@given(st.permutations(range(8)), st.integers(1, 6), seeds, st.binary(max_size=24), st.sampled_from(["little", "big"]))
def test_any_order_of_joints_any_padding_any_endianness(columns, points, seed, tail, endianness):
    """Also with bytes after the message, as rclpy's serialize_message leaves them."""
    values = np.random.default_rng(seed).standard_normal((points, 8))
    since = np.arange(points) * 1000
    raw = trajectory(7, [JOINTS[j] for j in columns], since, {"positions": values[:, columns]}, "somewhere")
    parsed = STORE.deserialize_cdr(raw, TRAJECTORY)
    raw = bytes(STORE.serialize_cdr(parsed, TRAJECTORY, little_endian=endianness == "little")) + tail
    read = Decoder(TRAJECTORY, JOINTS)
    for numbers in (read(raw), read(raw)):  # learning the layout, and using it
        assert np.array_equal(numbers["positions"], values)
        assert np.array_equal(numbers["time_from_start"], since)
        assert numbers["stamp"] == 7
        assert "velocities" not in numbers


def test_many_messages_of_many_layouts_at_once():
    random = np.random.default_rng(1)
    raws, expected = [], []
    for _ in range(60):
        points, columns = int(random.integers(0, 4)), random.permutation(8)
        fields = {"positions": random.standard_normal((points, 8)), "effort": random.standard_normal((points, 8))}
        fields = {name: values for name, values in fields.items() if random.random() < 0.8}
        names = [JOINTS[j] for j in columns]
        shuffled = {name: values[:, columns] for name, values in fields.items()}
        raws.append(trajectory(int(random.integers(1e9)), names, np.arange(points), shuffled))
        if random.random() < 0.3:  # foreign padding: the two option bytes of the CDR header
            raws[-1] = raws[-1][:3] + b"\x03" + raws[-1][4:]
        expected.append(fields if points else {})
    seen = []
    for indices, numbers in decode_all(raws, TRAJECTORY, JOINTS):
        seen += indices.tolist()
        for row, i in enumerate(indices):
            assert {"stamp", "time_from_start", *expected[i]} == set(numbers)
            assert all(np.array_equal(numbers[name][row], values) for name, values in expected[i].items())
    assert sorted(seen) == list(range(60))


def test_bytes_made_by_rclpy_decode():
    """rclpy leaves uninitialised bytes behind the message; rosbags' own deserializer refuses them."""
    from builtin_interfaces.msg import Duration
    from rclpy.serialization import serialize_message
    from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

    values = np.arange(24.0).reshape(3, 8)
    points = [JointTrajectoryPoint(positions=row.tolist(), time_from_start=Duration(nanosec=i)) for i, row in enumerate(values)]
    raw = serialize_message(JointTrajectory(joint_names=JOINTS, points=points))
    numbers = Decoder(TRAJECTORY, JOINTS)(raw)
    assert np.array_equal(numbers["positions"], values)
    assert numbers["time_from_start"].tolist() == [0, 1, 2]


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (JOINTS[:-1], "lacks joint rr_lift"),
        ((*JOINTS, "tail"), "unknown joint tail"),
        ((*JOINTS[:-1], "fl_lift"), "repeats joint fl_lift"),
    ],
)
def test_wrong_joints_are_named(names, said):
    raw = cdr(JOINT_STATE, header(0), list(names), np.zeros(len(names)), np.zeros(0), np.zeros(0))
    good = cdr(JOINT_STATE, header(0), list(JOINTS), np.zeros(8), np.zeros(0), np.zeros(0))
    read = Decoder(JOINT_STATE, JOINTS)
    for _ in range(2):  # the second like the first, and good ones in between
        with pytest.raises(BagError, match=said):
            read(raw)
        with pytest.raises(BagError, match=said):
            read(raw)
        assert read(good)["position"].shape == (8,)


def test_a_missing_value_is_named():
    raw = cdr(JOINT_STATE, header(0), list(JOINTS), np.zeros(7), np.zeros(0), np.zeros(0))
    with pytest.raises(BagError, match="names 8 joints but gives 7 values of 'position'"):
        Decoder(JOINT_STATE, JOINTS)(raw)


@pytest.mark.parametrize("kind", ["trajectory", "state", "odometry", "clock"])
def test_a_message_cut_off_anywhere_is_refused(kind):
    layouts = {
        "trajectory": (trajectory_layout(JOINTS, ("positions",), 2, "base"), TRAJECTORY),
        "state": (state_layout(JOINTS), JOINT_STATE),
        "odometry": (odometry_layout(), ODOMETRY),
        "clock": (clock_layout(), CLOCK),
    }
    layout, msgtype = layouts[kind]
    raw = bytes(Frame(layout))
    assert deserialize(raw, msgtype) is not None
    for cut in range(len(raw)):
        with pytest.raises(BagError, match="cannot be decoded"):
            deserialize(raw[:cut], msgtype)


@given(st.binary(max_size=200), st.integers(0, 400), st.integers(0, 255))
def test_bytes_that_are_no_message_are_refused_in_one_sentence(raw, place, value):
    good = bytearray(trajectory(0, JOINTS, np.arange(2), {"positions": np.zeros((2, 8))}))
    good[place % len(good)] = value
    for candidate in (raw, b"\x00\x01\x00\x00" + raw, bytes(good), bytes(good[:place])):
        try:
            deserialize(candidate, TRAJECTORY)
        except BagError as error:
            assert str(error).count("\n") == 0
