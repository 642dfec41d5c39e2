"""`hamr bag check` sees every frame that is dropped, repeated or out of order, and says which."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
import yaml
from bag_samples import ACTUATORS, PERIOD_NS, Run, cdr, foreign, header, message, record, run, trajectory

from hamr_bags.check import check
from hamr_bags.topics import SERVO
from hamr_bags.writer import BagWriter
from hamr_description.errors import BagError
from hamr_description.names import JOINTS, Topic

N = 12


@pytest.fixture(scope="module")
def source() -> Run:
    return run(frames=N)


def failed(bag) -> dict[str, str]:
    return {row.name: row.detail for row in check(bag).rows if not row.ok}


def test_a_whole_bag_passes(source, tmp_path):
    report = check(record(tmp_path / "bag", source, info=source.info(excitation={"seconds": N * 0.004})))
    assert report.ok
    assert report.warnings == ()
    counts = [row.detail for row in report.rows if row.name.endswith("count")]
    assert counts == ["48 samples, 48 expected (0.048 s at 1000 Hz)"] * 3


def test_a_whole_bag_of_another_recorder_passes_with_warnings(source, tmp_path):
    report = check(foreign(tmp_path / "bag", source, columns=[3, 1, 2, 0, 7, 6, 5, 4]))
    assert report.ok
    assert "there is no /run_info" in report.warnings
    assert sum("another clock recorded it" in warning for warning in report.warnings) == 3


@pytest.mark.parametrize("topic", SERVO)
@pytest.mark.parametrize(
    ("frames", "names"),
    [
        ([*range(5), *range(6, N)], {"gaps", "count"}),  # dropped inside
        (range(N - 1), set()),  # dropped at the end: only the other topics know
        (range(1, N), set()),
        ([*range(5), 4, *range(5, N)], {"order", "count"}),  # repeated
        ([0, 1, 3, 2, *range(4, N)], {"order", "gaps"}),  # swapped
    ],
)
def test_one_frame_wrong_in_one_topic(source, tmp_path, topic, frames, names):
    wrong = failed(record(tmp_path / "bag", source, order=lambda t: frames if t == topic else range(N)))
    assert {name for name in wrong if not name.endswith("times")} == {f"{topic} {name}" for name in names}
    assert any(name.endswith("times") for name in wrong)


@pytest.mark.parametrize("frames", [range(N - 1), range(1, N), [*range(N), N - 1]])
def test_a_frame_missing_or_repeated_everywhere_shows_against_the_plan(source, tmp_path, frames):
    info = source.info(excitation={"seconds": N * 0.004})
    wrong = failed(record(tmp_path / "bag", source, order=lambda _: frames, info=info))
    assert {f"{topic} count" for topic in SERVO} <= set(wrong)


def test_where_it_is_wrong_is_said(source, tmp_path):
    wrong = failed(record(tmp_path / "bag", source, order=lambda _: [0, 1, 4, *range(5, N)]))
    assert wrong["/servo/joints gaps"] == "8 missing in 1 places, first at 3.007000 s"
    assert wrong["/servo/joints count"] == "40 samples, 48 expected (0.048 s at 1000 Hz)"


def test_another_rate_than_promised(source, tmp_path):
    wrong = failed(record(tmp_path / "bag", source, info=replace(source.info(), samples_per_frame=8)))
    assert {f"{topic} {what}" for topic in SERVO for what in ("gaps", "count", "samples per frame")} == set(wrong)


def test_an_index_that_does_not_count_right(source, tmp_path):
    bag = record(tmp_path / "bag", source)
    metadata = yaml.safe_load((bag / "metadata.yaml").read_text())
    metadata["rosbag2_bagfile_information"]["topics_with_message_count"][1]["message_count"] += 1
    (bag / "metadata.yaml").write_text(yaml.safe_dump(metadata))
    assert failed(bag) == {"messages": "/servo/joints 12 stored, 13 indexed"}


def with_clock(out, source: Run, ticks, states=()):
    stamp = "builtin_interfaces/msg/Time"
    with BagWriter(out) as writer:
        for k in range(source.frames):
            ns = source.start_ns + k * PERIOD_NS
            for topic in SERVO:
                names = JOINTS if topic == Topic.SERVO_JOINTS else ACTUATORS
                writer.write(topic, trajectory(ns, names, np.arange(4) * 1_000_000, source.frame(topic, k)), ns)
        for k in ticks:
            ns = source.start_ns + k * PERIOD_NS
            writer.write(Topic.CLOCK, cdr("rosgraph_msgs/msg/Clock", message(stamp, *divmod(ns, 10**9))), ns)
        for topic in states:
            for k in ticks:
                ns = source.start_ns + k * PERIOD_NS
                raw = cdr("sensor_msgs/msg/JointState", header(ns), list(JOINTS), np.zeros(8), np.zeros(0), np.zeros(0))
                writer.write(topic, raw, ns)
    return out


def test_clock_ticks_with_the_frames(source, tmp_path):
    assert check(with_clock(tmp_path / "whole", source, range(N + 1))).ok
    lost = [*range(5), *range(6, N)]
    wrong = failed(with_clock(tmp_path / "lost", source, lost))
    assert wrong["/clock gaps"] == "1 missing in 1 places, first at 3.016000 s"
    assert wrong["/servo/joints on /clock"] == "no tick in 1 places, first at 3.020000 s"


def test_a_repeated_tick_is_seen(source, tmp_path):
    wrong = failed(with_clock(tmp_path / "bag", source, [*range(6), 5, *range(6, N)]))
    assert wrong == {"/clock order": "repeats in 1 places, first at 3.020000 s"}


def test_a_missed_target_is_a_warning_a_missed_state_is_not(source, tmp_path):
    lost = [*range(5), *range(6, N)]
    report = check(with_clock(tmp_path / "bag", source, lost, states=(Topic.JOINT_STATES, Topic.LEG_TARGETS)))
    assert "/joint_states gaps" in {row.name for row in report.rows if not row.ok}
    assert "/leg_targets gaps: 1 missing in 1 places, first at 3.016000 s" in report.warnings


def altered(source: Run, topic: str, change) -> Run:
    field = "effort" if topic == Topic.SERVO_VOLTAGES else "positions"
    values = source.numbers[topic][field].copy()
    change(values)
    return replace(source, numbers=source.numbers | {topic: source.numbers[topic] | {field: values}})


def test_dead_saturated_and_stopped_channels_are_warned_of(source, tmp_path):
    def dead(values):
        values[:, 3] = 0.01

    def saturated(values):
        values[:13, 6] = 225.0  # 27 %

    def stopped(values):
        values[7, 0] = -0.3e-3

    found = altered(altered(altered(source, SERVO[0], dead), SERVO[1], stopped), SERVO[2], saturated)
    report = check(record(tmp_path / "bag", found))
    assert report.ok
    assert report.warnings == (
        "/servo/joints: rl_lift never changes",
        "/servo/actuators: fl_swing is at an end stop in 1 of 48 samples",
        "/servo/voltages: rr_swing is at 0 or 225 V in 13 of 48 samples",
    )


def test_not_a_number_is_found(source, tmp_path):
    def break_it(values):
        values[9, 2] = np.nan

    wrong = failed(record(tmp_path / "bag", altered(source, Topic.SERVO_ACTUATORS, break_it)))
    assert wrong == {"/servo/actuators numbers": "not finite in 1 places, first at 3.009000 s"}


@pytest.mark.parametrize("seconds", ["12", None, float("nan"), [1]])
def test_a_plan_that_is_no_number_is_no_plan(source, tmp_path, seconds):
    info = json.dumps(json.loads(source.info().to_json()) | {"excitation": {"seconds": seconds}})
    assert check(foreign(tmp_path / "bag", source, info=info)).ok


@pytest.mark.parametrize(("names", "points", "said"), [(JOINTS, 0, "without samples"), (JOINTS[::2], 3, "lacks joint fl_lift")])
def test_frames_that_cannot_be_read_are_named_with_their_topic(tmp_path, names, points, said):
    with BagWriter(tmp_path / "bag") as writer:
        raw = trajectory(0, names, np.arange(points), {"positions": np.zeros((points, len(names)))})
        writer.write(Topic.SERVO_JOINTS, raw, 0)
    with pytest.raises(BagError, match=f"bag, /servo/joints: .*{said}"):
        check(tmp_path / "bag")


def test_a_bag_of_other_things_is_refused(tmp_path):
    with BagWriter(tmp_path / "bag") as writer:
        writer.write("/number", cdr("std_msgs/msg/Int32", 7), 5, "std_msgs/msg/Int32")
    with pytest.raises(BagError, match="holds none of /servo/joints"):
        check(tmp_path / "bag")
