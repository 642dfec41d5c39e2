"""as_measured, flatten, info and the functions behind `hamr bag`."""

from __future__ import annotations

import json

import numpy as np
import pytest
from bag_samples import JOINTS, Run, record, run
from rosbags.highlevel import AnyReader

from hamr_bags import cli
from hamr_bags.as_measured import as_measured, strokes
from hamr_bags.bag import open_bag
from hamr_bags.check import check
from hamr_bags.flatten import SAMPLES_ACTUATORS, SAMPLES_JOINTS, flatten
from hamr_bags.reader import channels, load, run_info
from hamr_bags.recording import digest
from hamr_description.errors import BagError
from hamr_description.names import ACTUATORS, Topic

JOINT_TOPICS = (Topic.SERVO_JOINTS, Topic.SERVO_ACTUATORS)


@pytest.fixture(scope="module")
def source() -> Run:
    return run(frames=100, per_frame=16)


@pytest.fixture(scope="module")
def bag(tmp_path_factory, source):
    info = source.info(excitation={"kind": "noise", "seconds": 0.4}, effects=[{"effect": "backlash"}], seed=9)
    return record(tmp_path_factory.mktemp("tools") / "run", source, info=info)


class TestAsMeasured:
    def test_strokes_are_the_target_range_and_the_travel_between_the_stops(self):
        assert strokes() == pytest.approx({Topic.SERVO_JOINTS: np.radians(50), Topic.SERVO_ACTUATORS: 0.6e-3})

    @pytest.mark.parametrize("noise", [1e-3, 1e-2])
    def test_noise_is_white_and_of_the_size_asked_for(self, bag, tmp_path, noise):
        truth, noisy = load(bag), load(as_measured(bag, tmp_path / "m", noise=noise))
        errors = np.concatenate([noisy.angles - truth.angles, noisy.deflections - truth.deflections], axis=1)
        assert np.abs(np.corrcoef(errors.T) - np.eye(16)).max() < 0.15  # 1600 samples: sigma 0.025
        for name, stroke in (("angles", np.radians(50)), ("deflections", 0.6e-3)):
            error = (getattr(noisy, name) - getattr(truth, name)) / (noise * stroke)
            assert error.std() == pytest.approx(1, abs=0.03)  # 12800 samples: sigma 0.006
            assert np.abs(error.mean(axis=0)).max() < 0.15  # 1600 samples: sigma 0.025
            assert np.abs((error[1:] * error[:-1]).mean()) < 0.05
        assert np.array_equal(noisy.voltages, truth.voltages)
        assert np.array_equal(noisy.time, truth.time)

    def test_what_only_a_simulation_knows_is_gone(self, bag, tmp_path):
        out = as_measured(bag, tmp_path / "m", seed=3)
        assert set(channels(out)) == {"voltages", "angles", "deflections"}
        info = run_info(out)
        assert (info.backend, info.engine, info.parameters_hash, info.excitation, info.effects, info.seed) == ("", "", "", {}, [], 0)
        assert (info.environment, info.samples_per_frame, info.as_measured) == ("suspended", 16, {"noise": 1e-3, "seed": 3})
        with open_bag(out) as opened:
            assert set(opened.types) == {Topic.RUN_INFO, Topic.SERVO_JOINTS, Topic.SERVO_ACTUATORS, Topic.SERVO_VOLTAGES}
        assert check(out).ok

    def test_equal_seeds_give_equal_numbers(self, bag, tmp_path):
        first, again, other = (digest(load(as_measured(bag, tmp_path / str(i), seed=seed))) for i, seed in enumerate((1, 1, 2)))
        assert first == again != other

    def test_without_noise_the_numbers_stay(self, bag, tmp_path):
        assert digest(load(as_measured(bag, tmp_path / "m", noise=0.0))) == digest(load(bag))

    @pytest.mark.parametrize("noise", [-0.1, np.nan, 2.0])
    def test_noise_must_be_a_share(self, bag, tmp_path, noise):
        with pytest.raises(BagError, match="give it as a share of the stroke"):
            as_measured(bag, tmp_path / "m", noise=noise)
        assert not (tmp_path / "m").exists()


def test_flatten_gives_one_message_per_sample(bag, source, tmp_path):
    assert flatten(bag, tmp_path / "flat") == 1600
    with AnyReader([tmp_path / "flat"]) as reader:
        found = {SAMPLES_JOINTS: [], SAMPLES_ACTUATORS: []}
        for connection, stamp, raw in reader.messages([c for c in reader.connections if c.topic in found]):
            found[connection.topic].append((stamp, reader.deserialize(raw, connection.msgtype)))
        assert {c.topic for c in reader.connections} == {*found, Topic.RUN_INFO}
    joints, actuators, voltages = source.numbers.values()
    for topic, names, numbers in (
        (SAMPLES_JOINTS, JOINTS, {"position": joints["positions"], "velocity": joints["velocities"], "effort": np.zeros((1600, 0))}),
        (
            SAMPLES_ACTUATORS,
            ACTUATORS,
            {"position": actuators["positions"], "velocity": actuators["velocities"], "effort": voltages["effort"]},
        ),
    ):
        stamps = [stamp for stamp, _ in found[topic]]
        assert stamps == (source.start_ns + np.arange(1600) * 250_000).tolist()
        assert all(tuple(state.name) == names for _, state in found[topic])
        for field, values in numbers.items():
            assert np.array_equal([getattr(state, field) for _, state in found[topic]], values)


def test_flatten_leaves_empty_what_the_bag_does_not_have(bag, tmp_path):
    flatten(as_measured(bag, tmp_path / "m"), tmp_path / "flat")
    with AnyReader([tmp_path / "flat"]) as reader:
        states = {c.topic: reader.deserialize(raw, c.msgtype) for c, _, raw in reader.messages() if c.topic != Topic.RUN_INFO}
    assert [len(state.velocity) for state in states.values()] == [0, 0]
    assert [len(state.position) for state in states.values()] == [8, 8]


def test_commands_return_what_json_can_hold(bag, tmp_path, source):
    checked = json.loads(json.dumps(cli.check(bag)))
    assert checked["ok"] is True
    assert {"name": "/servo/joints count", "ok": True, "detail": "1600 samples, 1600 expected (0.4 s at 4000 Hz)"} in checked["rows"]
    information = json.loads(json.dumps(cli.info(bag)))
    assert information["seconds"] == pytest.approx(0.396)
    assert information["bytes"] == sum(file.stat().st_size for file in bag.iterdir())
    assert information["run_info"]["seed"] == 9
    servo = {"topic": Topic.SERVO_JOINTS, "type": "trajectory_msgs/msg/JointTrajectory", "messages": 100, "hz": pytest.approx(250)}
    assert servo in information["topics"]
    repaired = json.loads(json.dumps(cli.repair(bag, tmp_path / "repaired")))
    assert repaired == {"bag": str(tmp_path / "repaired"), "messages": 301, "chunks": repaired["chunks"], "lost_bytes": 0, "left_out": []}
    assert json.loads(json.dumps(cli.flatten(bag))) == {"bag": str(bag.with_name("run_flat")), "samples": 1600}
