"""What is written is a bag in the eyes of others: rosbags, mcap with ROS 2 support, rosbag2's metadata."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml
from bag_samples import STRING, TRAJECTORY, cdr, header, message, record, run
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.interfaces import QosDurability, QosReliability
from rosbags.rosbag2 import Reader

from hamr_bags.cdr import text
from hamr_bags.reader import load
from hamr_bags.recorder import Recorder
from hamr_bags.repair import repair
from hamr_bags.run_info import RunInfo
from hamr_bags.topics import SERVO
from hamr_bags.writer import CHUNK_BYTES, RUN_INFO_RECORD, BagWriter
from hamr_description.errors import BagError
from hamr_description.names import JOINTS, Topic

# Fields of rosbag2_storage::BagMetadata version 9 as rosbag2_storage/yaml.hpp of ROS 2 Jazzy encodes them, in its order.
METADATA = (
    "version", "storage_identifier", "duration", "starting_time", "message_count", "topics_with_message_count",
    "compression_format", "compression_mode", "relative_file_paths", "files", "custom_data", "ros_distro",
)  # fmt: skip
TOPIC = ("name", "type", "serialization_format", "offered_qos_profiles", "type_description_hash")
QOS = (
    "history", "depth", "reliability", "durability", "deadline", "lifespan", "liveliness", "liveliness_lease_duration",
    "avoid_ros_namespace_conventions",
)  # fmt: skip
# As stated in the type descriptions that the ROS 2 Jazzy packages install (share/*/msg/*.json).
HASHES = {
    TRAJECTORY: "RIHS01_179b33eba59d676f6d967ac71fe35e7ca2f64b2f3928f4a018cec115e213796e",
    STRING: "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18",
}


@pytest.fixture(scope="module")
def source():
    return run()


@pytest.fixture(scope="module")
def bag(tmp_path_factory, source):
    return record(tmp_path_factory.mktemp("written") / "run", source)


def test_rosbags_reads_it(bag, source):
    with AnyReader([bag]) as reader:
        connections = [c for c in reader.connections if c.topic == Topic.SERVO_JOINTS]
        messages = [(stamp, reader.deserialize(raw, c.msgtype)) for c, stamp, raw in reader.messages(connections)]
    assert len(messages) == source.frames
    for k, (stamp, frame) in enumerate(messages):
        assert stamp == source.start_ns + k * 4_000_000 == frame.header.stamp.sec * 10**9 + frame.header.stamp.nanosec
        assert tuple(frame.joint_names) == JOINTS
        truth = source.frame(Topic.SERVO_JOINTS, k)
        for i, point in enumerate(frame.points):
            for field, values in truth.items():
                assert np.array_equal(getattr(point, field), values[i])


def test_mcap_reads_it_from_the_schemas_inside(bag, source):
    seen = dict.fromkeys(SERVO, 0)
    with next(bag.glob("*.mcap")).open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        assert reader.get_header().profile == "ros2"
        for schema, channel, stored, frame in reader.iter_decoded_messages(topics=SERVO):
            k, seen[channel.topic] = seen[channel.topic], seen[channel.topic] + 1
            assert (schema.name, schema.encoding) == (TRAJECTORY, "ros2msg")
            assert stored.log_time == stored.publish_time == frame.header.stamp.sec * 10**9 + frame.header.stamp.nanosec
            efforts = np.array([point.effort for point in frame.points])
            assert np.array_equal(efforts, source.frame(channel.topic, k)["effort"])
        records = {record.name: record.metadata for record in reader.iter_metadata()}
    assert set(seen.values()) == {source.frames}
    assert RunInfo.from_json(records[RUN_INFO_RECORD]["json"]) == source.info()
    inner = yaml.safe_load(records["rosbag2"]["serialized_metadata"])
    assert inner == yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]


def test_metadata_has_the_fields_of_rosbag2(bag, source):
    text = (bag / "metadata.yaml").read_text()
    information = yaml.safe_load(text)["rosbag2_bagfile_information"]
    assert tuple(information) == METADATA
    assert "&" not in text  # no YAML anchors
    assert information["version"] == 9
    assert information["storage_identifier"] == "mcap"
    assert information["ros_distro"] == "jazzy"
    assert information["starting_time"] == {"nanoseconds_since_epoch": source.start_ns}
    assert information["duration"] == {"nanoseconds": (source.frames - 1) * 4_000_000}
    assert information["message_count"] == 3 * source.frames + 1
    assert [bag / path for path in information["relative_file_paths"]] == list(bag.glob("*.mcap"))
    (file,) = information["files"]
    assert file == {key: information[key] for key in ("starting_time", "duration", "message_count")} | {"path": f"{bag.name}.mcap"}
    counts = {}
    for topic in information["topics_with_message_count"]:
        assert tuple(topic) == ("topic_metadata", "message_count")
        assert tuple(topic["topic_metadata"]) == TOPIC
        assert topic["topic_metadata"]["type_description_hash"] == HASHES[topic["topic_metadata"]["type"]]
        (qos,) = topic["topic_metadata"]["offered_qos_profiles"]
        assert tuple(qos) == QOS
        counts[topic["topic_metadata"]["name"]] = topic["message_count"]
    assert counts == {Topic.RUN_INFO: 1, **dict.fromkeys(SERVO, source.frames)}


@pytest.mark.parametrize("bare", [False, True])
def test_latched_topics_play_as_transient_local(bag, bare):
    with Reader(next(bag.glob("*.mcap")) if bare else bag) as reader:
        profiles = {c.topic: c.ext.offered_qos_profiles[0] for c in reader.connections}
    assert profiles[Topic.RUN_INFO].durability == QosDurability.TRANSIENT_LOCAL
    assert profiles[Topic.SERVO_JOINTS].durability == QosDurability.VOLATILE
    assert {profile.reliability for profile in profiles.values()} == {QosReliability.RELIABLE}


def test_equal_runs_give_equal_bytes(bag, source, tmp_path):
    again = record(tmp_path / "run", source)
    for file in ("run.mcap", "metadata.yaml"):
        assert (again / file).read_bytes() == (bag / file).read_bytes()


def test_a_bag_is_never_overwritten(bag):
    with pytest.raises(BagError, match="exists already; choose another name or remove it"):
        BagWriter(bag)


def test_a_place_that_cannot_be_made_is_named(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(BagError, match="cannot be made"):
        BagWriter(tmp_path / "file" / "bag")


def test_other_standard_types_are_stored_others_refused(tmp_path):
    raw = cdr("std_msgs/msg/Int32", 7)
    with BagWriter(tmp_path / "bag") as writer:
        writer.write("/number", raw, 5, "std_msgs/msg/Int32")
        with pytest.raises(BagError, match="no standard message"):
            writer.write("/odd", raw, 6, "hamr_msgs/msg/Odd")
    with Reader(tmp_path / "bag") as reader:
        assert [(c.topic, stamp, bytes(data)) for c, stamp, data in reader.messages()] == [("/number", 5, raw)]


def test_an_empty_bag_is_a_bag(tmp_path):
    with BagWriter(tmp_path / "bag"):
        pass
    with Reader(tmp_path / "bag") as reader:
        assert reader.message_count == 0


def test_what_was_written_before_an_error_is_kept(tmp_path, source):
    with pytest.raises(RuntimeError), BagWriter(tmp_path / "bag") as writer:
        writer.write(Topic.RUN_INFO, cdr(STRING, source.info().to_json()), 0)
        raise RuntimeError
    with Reader(tmp_path / "bag") as reader:
        assert reader.message_count == 1


KILLED = """
import os, signal, sys
import numpy as np
from hamr_bags.frames import servo_frame
from hamr_bags.writer import BagWriter
from hamr_description.names import Topic
writer, frame = BagWriter(sys.argv[1]), servo_frame(Topic.SERVO_JOINTS, 80)
random = np.random.default_rng(0)
for k in range(60):
    frame.stamp(k * 4_000_000)
    frame.numbers["positions"][:] = random.standard_normal((80, 8))
    writer.write(Topic.SERVO_JOINTS, bytes(frame), k * 4_000_000)
os.kill(os.getpid(), signal.SIGKILL)
"""


def test_kill_9_loses_less_than_a_chunk(tmp_path):
    bag = tmp_path / "bag"
    assert subprocess.run([sys.executable, "-c", KILLED, bag], check=False).returncode == -9
    with pytest.raises(BagError, match=r"was not closed.*hamr bag repair"):
        load(bag)
    repaired = repair(bag)
    frame_bytes = 80 * (4 * 72 + 8)
    assert 60 - repaired.messages <= CHUNK_BYTES / frame_bytes + 1
    with Reader(repaired.bag) as reader:
        assert [stamp for _, stamp, _ in reader.messages()] == [k * 4_000_000 for k in range(repaired.messages)]


class TestRecorder:
    def twist(self) -> bytes:
        zero = message("geometry_msgs/msg/Vector3", 0.0, 0.0, 0.0)
        return cdr("geometry_msgs/msg/Twist", zero, zero)

    def state(self, ns: int) -> bytes:
        return cdr("sensor_msgs/msg/JointState", header(ns), list(JOINTS), np.zeros(8), np.zeros(0), np.zeros(0))

    def stored(self, bag: Path) -> list[tuple[str, int]]:
        with Reader(bag) as reader:
            return [(c.topic, stamp) for c, stamp, _ in reader.messages()]

    def test_messages_without_a_stamp_get_the_sim_time_also_those_before_the_clock(self, tmp_path):
        with Recorder(tmp_path / "bag") as recorder:
            recorder.write(Topic.RUN_INFO, cdr(STRING, run().info().to_json()))
            recorder.write(Topic.CMD_VEL, self.twist())
            recorder.write(Topic.JOINT_STATES, self.state(10**11))
            recorder.write(Topic.CMD_VEL, self.twist())
        expected = [(Topic.RUN_INFO, 10**11), (Topic.CMD_VEL, 10**11), (Topic.JOINT_STATES, 10**11), (Topic.CMD_VEL, 10**11)]
        assert sorted(self.stored(recorder.path)) == sorted(expected)

    def test_a_clock_that_never_comes_loses_nothing(self, tmp_path):
        with Recorder(tmp_path / "bag") as recorder:
            recorder.write(Topic.CMD_VEL, self.twist())
        assert self.stored(recorder.path) == [(Topic.CMD_VEL, 0)]

    def test_a_stamp_that_jumps_back_is_left_out_and_recording_goes_on(self, tmp_path):
        with Recorder(tmp_path / "bag") as recorder:
            recorder.write(Topic.JOINT_STATES, self.state(2_000_000_000))
            with pytest.raises(BagError, match=r"/joint_states jumped back by 0.5 s to 1.500000 s"):
                recorder.write(Topic.JOINT_STATES, self.state(1_500_000_000))
            recorder.write(Topic.LEG_TARGETS, self.state(1_600_000_000))  # another topic may lag
            recorder.write(Topic.JOINT_STATES, self.state(2_004_000_000))
        stamps = [stamp for topic, stamp in self.stored(recorder.path) if topic == Topic.JOINT_STATES]
        assert stamps == [2_000_000_000, 2_004_000_000]

    def test_an_unknown_topic_is_named(self, tmp_path):
        with Recorder(tmp_path / "bag") as recorder, pytest.raises(BagError, match="/tf is not recorded; the topics are /clock"):
            recorder.write("/tf", b"")


def test_run_info_text_survives_the_bag(bag, source):
    with Reader(bag) as reader:
        (raw,) = [raw for c, _, raw in reader.messages() if c.topic == Topic.RUN_INFO]
    assert RunInfo.from_json(text(raw)) == source.info()
