"""Parts of the workflow after the verdict, each against a truth of its own."""

from __future__ import annotations

import os
from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from oscillator import oscillator

from hamr_bags.cdr import NS
from hamr_bags.frames import trajectory_layout
from hamr_bags.layout import Frame
from hamr_bags.writer import BagWriter
from hamr_description.errors import BagError
from hamr_description.names import JOINTS, Topic, drive_sign
from hamr_dynamics.effects.effects_file import PlacedEffect
from hamr_gap.answers.answer import answer, merged, place_of
from hamr_gap.answers.found import Found, find
from hamr_gap.answers.together import together
from hamr_gap.data.drives_bag import write_drives
from hamr_gap.data.measured import FIELDS, read
from hamr_gap.judging.analyse import analyse
from hamr_gap.judging.table import fit_table
from hamr_gap.naming.prepare import prepare
from hamr_gap.progress import side_by_side
from hamr_gap.showing import emit
from hamr_gap.showing.words import HEADLINES, answer_in_words, sentences
from hamr_gap.study import stored

STEP = 1e-3
HZ = 4000


def frames(path, topics: dict[str, tuple[np.ndarray, np.ndarray]], per: int = 16):
    """A bag of both joints of one leg; topic -> times (m,) ns of the messages, values (m, per, 2)."""
    with BagWriter(path) as bag:
        for topic, (times, values) in topics.items():
            names = JOINTS[:2] if topic == Topic.SERVO_JOINTS else tuple(f"{joint}_actuator" for joint in JOINTS[:2])
            field = FIELDS[topic]
            count = values.shape[1]
            frame = Frame(trajectory_layout(names, (field,), count))
            frame.numbers["time_from_start"][:] = np.stack(np.divmod(np.arange(count) * (4_000_000 // count), NS), axis=-1)
            for time, part in zip(times.tolist(), values, strict=True):
                frame.stamp(time)
                frame.numbers[field][:] = part
                bag.write(topic, bytes(frame), time)
    return path


def test_lost_messages_are_nan_where_they_were_and_drives_may_be_faster(tmp_path):
    random = np.random.default_rng(0)
    times = np.arange(10) * 4_000_000
    angles, volts = random.normal(size=(10, 16, 2)), random.normal(size=(10, 80, 2))
    kept = np.delete(np.arange(10), 4)
    bag = frames(tmp_path / "bag", {Topic.SERVO_JOINTS: (times[kept], angles[kept]), Topic.SERVO_VOLTAGES: (times, volts)})
    samples = read(bag)
    assert samples.legs == ("fl",)
    assert samples.deflections is None
    lost = np.isnan(samples.angles).all(1)
    assert np.flatnonzero(lost).tolist() == list(range(64, 80))
    np.testing.assert_array_equal(samples.angles[~lost], angles[kept].reshape(-1, 2))
    np.testing.assert_array_equal(samples.voltages, volts.reshape(-1, 2))


@pytest.mark.parametrize(("shift", "says"), [(110_000, "even clock"), (10 * NS, "no time in common")])
def test_clocks_that_disagree_are_said(tmp_path, shift, says):
    times, values = np.arange(10) * 4_000_000, np.zeros((10, 16, 2))
    joints = times + shift if shift > NS else times + (np.arange(10) % 3 > 0) * shift
    with pytest.raises(BagError, match=says):
        read(frames(tmp_path / "bag", {Topic.SERVO_JOINTS: (joints, values), Topic.SERVO_VOLTAGES: (times, values)}))


@pytest.mark.parametrize(
    ("joints", "word"),
    [
        (JOINTS[::2], "swing"), (JOINTS, "all"), (JOINTS[:2], "fl"), (JOINTS[3:4], "rl_lift"), (("arm",), "arm"),
        ((JOINTS[0], JOINTS[3]), "fl_swing, rl_lift"), ((), "chassis"),
    ],
)  # fmt: skip
def test_places_have_the_shortest_name(joints, word):
    assert place_of(joints) == word


def effect(joint: str, value: float) -> dict:
    estimate = {"value": value, "low": value - 1.0, "high": value + 1.0, "unit": "N*m"}
    return {"effect": "backlash", "form": "gap", "joints": [joint], "parameters": {"level": {joint: estimate}}}


def test_equal_names_of_several_legs_become_one():
    (one,) = merged([effect(joint, x) for joint, x in zip(JOINTS[::2], (1.0, 2.0, 3.0, 9.0), strict=True)])
    assert one["place"] == "swing"
    level = one["parameters"]["level"]
    assert (level["value"], level["low"], level["high"]) == (2.5, 0.0, 10.0)
    each = zip(JOINTS[::2], (1.0, 2.0, 3.0, 9.0), strict=True)
    assert level["at"] == {joint: effect(joint, x)["parameters"]["level"][joint] for joint, x in each}


@pytest.mark.parametrize(("other", "said"), [
    (9.0, "level 1 (0 to 2) N*m at fl_swing and 9 (8 to 10) N*m at fl_lift"), (2.0, "level 1.5 (0 to 3) N*m"),
])  # fmt: skip
def test_joints_that_differ_are_said_one_by_one(other, said):
    """A shoulder's friction and an elbow's were told as one, halfway between."""
    (one,) = merged([effect("fl_swing", 1.0), effect("fl_lift", other)])
    assert answer_in_words({"effects": [one], "unknown": 0}) == f"backlash (gap) at fl, {said}"


def verdict(name: str, *answers: tuple[str, float]) -> Found:
    gap = {"raw": 3.0, "retuned": 2.0, "after": 1.0, "floor": 1.0, "per_channel": {}}
    found = [{"effects": [effect(e, 1.0)], "probability": p, "left": 0.0, "forms": {}, "unknown": name == "unknown"} for e, p in answers]
    content = {
        "joints": ("fl_swing", "fl_lift"),
        "verdict": name,
        "set": found,
        "gap": gap,
        "parameters": {},
        "not_observable": {},
        "where": [],
        "notes": [],
        "experiment": None,
    }
    return Found(content, [], {}, {}, found)


def test_the_common_factor_is_spoken_of_where_there_is_one():
    """Not of a single joint whose gain a record tells."""
    leg, arm = verdict("named", ("fl_swing", 0.95)), verdict("named", ("fl_swing", 0.95))
    leg.verdict.update({"parameters": {"gain": {"fl_swing": {"value": 0.1}}}})
    arm.verdict.update({"joints": ("arm",), "parameters": {"gain": {"arm": {"value": -0.2}}}})
    cart = verdict("named", ("fl_swing", 0.95))
    cart.verdict.update({"joints": ("cart",), "parameters": {"inertia": {"cart": {"value": 0.1}}}})
    assert [len(answer({"own": found}, [])["notes"]) for found in (leg, cart, arm)] == [1, 1, 0]


def test_of_an_unknown_law_what_comes_nearest_is_said():
    rows = [("lag + drag", 2, 0.4), ("lag", 1, 0.5), ("drag", 1, 0.9), ("lag + drag + play", 3, 0.45)]
    tried = [dict(zip(("effects", "count", "left"), row, strict=True)) for row in rows]
    own = {"verdict": "unknown", "set": [], "added": [], "tried": tried}
    found = {"verdict": "unknown", "set": [{"effects": [], "probability": 0.9, "unknown": 1}], "machines": {"arm": own}}
    found |= {"refused": {}, "experiment": None}
    nearest = "What comes nearest at arm: lag leaves 50 % of the gap; lag + drag leaves 40 % of the gap."
    assert nearest in sentences(found)
    assert nearest not in sentences(found | {"machines": {"arm": own | {"verdict": "named"}}})


@pytest.mark.parametrize(("added", "closed", "said"), [
    ([], 0.0, "In the sensors' own units, likewise: 0.012, 0.006 rad at arm."),
    (["hum"], 0.75, "75.0 % of the re-tuned gap is gone; taken out again, it is 8.00."),
    (["hum"], -48.6, "What was found does not hold there; taken out again, it is 8.00."),
])  # fmt: skip
def test_what_was_found_is_said_to_hold_only_where_it_does(added, closed, said):
    own = {"verdict": "unknown", "set": [], "added": [{"effect": name} for name in added], "tried": []}
    channels = {"arm": {"unit": "rad", "noise": 1e-3, "raw": 0.012, "retuned": 0.006, "after": 0.007}}
    shown = {"machines": {"arm": {"channels": channels}}, "data": "other data", "closed": closed}
    shown["over_floor"] = {"raw": 12.0, "retuned": 6.0, "after": 7.0, "removed": 8.0}
    found = {"verdict": "unknown", "set": [{"effects": [], "probability": 0.9, "unknown": 1}], "machines": {"arm": own}, "shown": shown}
    *others, last = sentences(found | {"refused": {}, "experiment": None})
    assert last.endswith(said)
    about = "6.00 re-tuned, 7.00 with what was found." if added else "6.00 re-tuned."
    assert any(sentence.endswith(about) for sentence in others)
    assert ("0.012, 0.006, 0.007 rad at arm" in " ".join(others)) == bool(added)


@pytest.mark.parametrize(("retuned", "told"), [(1.2, False), (4.0, True)])
def test_what_no_name_explains_surely_is_said_too(retuned, told):
    """A swinging arm left 195 times the noise, and was told that no effect was missing."""
    own = {"verdict": "parameters_only", "added": [], "gap": {"retuned": retuned, "floor": 1.0}, "detectable": {}}
    own |= {"tried": [{"effects": "drag", "count": 1, "left": 0.9}], "notes": ["8 % of the samples were left out."]}
    found = {"verdict": "parameters_only", "set": [], "machines": {"arm": own}, "parameters": [], "refused": {}, "experiment": None}
    said = sentences(found)
    assert ("4.0 times the noise at arm" in said[0]) == told
    assert ("What comes nearest at arm: drag leaves 90 % of the gap." in said) == told
    assert (said[0] == HEADLINES["parameters_only"]) == (not told)
    assert "arm: 8 % of the samples were left out." in said


def test_which_parameters_a_retune_surely_changes_is_said():
    """A motor that is 43 % weaker than its data sheet says is news, or dry friction."""
    changed = [("damping", -0.095, -0.1, -0.07, "N*m*s/rad"), ("gain", -0.432, -0.478, -0.386, "1"), ("preload", -0.02, -0.05, 0.01, "N*m")]
    parameters = [dict(zip(("name", "value", "low", "high", "unit"), row, strict=True)) | {"joint": "arm"} for row in changed]
    own = {"verdict": "parameters_only", "added": [], "gap": {"retuned": 1.0, "floor": 1.0}, "detectable": {}, "tried": [], "notes": []}
    found = {"verdict": "parameters_only", "set": [], "machines": {"arm": own}, "refused": {}, "experiment": None}
    said = "A re-tune changes gain of arm by -43.2 (-47.8 to -38.6) %, damping of arm by -0.095 (-0.1 to -0.07) N*m*s/rad."
    assert sentences(found | {"parameters": parameters})[1] == said
    assert not any("A re-tune" in sentence for sentence in sentences(found | {"parameters": parameters[2:]}))
    assert "and 1 more, in the report." in sentences(found | {"parameters": [*parameters[:2] * 2]})[1]


def test_legs_answer_together_and_the_least_certain_one_sets_the_tone():
    founds = {"fl": verdict("ambiguous", ("fl_swing", 0.6), ("fl_lift", 0.35)), "rl": verdict("named", ("rl_swing", 0.95))}
    whole = answer(*together(founds | {"fr": verdict("no_significant_gap")}))
    assert whole["verdict"] == "ambiguous"
    assert [a["effects"][0]["place"] for a in whole["set"]] == ["fl_swing, rl_swing", "fl_lift, rl_swing"]
    assert [a["probability"] for a in whole["set"]] == pytest.approx([0.57, 0.3325])


def test_a_named_part_of_an_unknown_answer_is_no_answer_of_other_legs():
    """Two legs in which the same name is but a part are not named by each other, and where one leg's is the whole it is not either."""
    founds = {"fl": verdict("unknown", ("fl_swing", 0.95)), "rl": verdict("named", ("rl_swing", 0.95))}
    whole = answer(*together(founds))
    assert whole["verdict"] == "unknown"
    assert [(len(a["effects"]), a["unknown"], a["probability"]) for a in whole["set"]] == [(1, 1, pytest.approx(0.9025))]
    own = {name: {"added": [], "tried": [], "verdict": "named", "set": f.verdict["set"]} for name, f in founds.items()}
    said = sentences(whole | {"machines": own})
    assert said[0].startswith("Part of what is missing has a name")
    assert said[1].endswith(" and a law outside the library.")
    own["fl"] |= {"set": [{"effects": [], "unknown": True}]}  # then the name is the other leg's, and no part
    assert sentences(whole | {"machines": own})[0] == HEADLINES["unknown"]


@pytest.mark.parametrize(("third", "said"), [("backlash", ["backlash"]), ("drive_lag", []), (None, [])])
def test_what_all_answers_have_is_said(third, said):
    """A measured double pendulum has friction in each of three answers, beside a gain that varies in one way or another."""
    answers = [["backlash", "drive_drift"], ["air_drag", "backlash"], [third] if third else []]
    each = [[{"effect": e, "form": "any", "place": "arm", "parameters": {}} for e in names] for names in answers]
    rows = [{"effects": effects, "probability": 0.3, "unknown": 0} for effects in each]
    found = {"verdict": "ambiguous", "set": rows, "machines": {}, "refused": {}, "experiment": None}
    assert [s for s in sentences(found) if s.startswith("In all of them")] == [f"In all of them: {name}." for name in said]


def test_an_effect_at_two_joints_is_written_for_each_with_its_own_parameters():
    each = {joint: {"value": x, "unit": "", "low": x, "high": x} for joint, x in zip(JOINTS[:2], (1e-6, 2e-6), strict=True)}
    width = {joint: {"value": 0.1, "unit": "", "low": 0.0, "high": 1.0} for joint in JOINTS[:2]}
    added = {"effect": "coulomb_friction", "form": "sign", "joints": list(JOINTS[:2]), "parameters": {"level": each, "width": width}}
    stiffer = {"stiffness": {JOINTS[1]: {"value": 1e-5, "unit": "N*m/rad", "low": 0.0, "high": 1.0}}}
    found = SimpleNamespace(verdict={"verdict": "named", "added": [added], "parameters": stiffer})
    file = emit.of_legs([found])
    assert file.effects == tuple(
        PlacedEffect("coulomb_friction", "sign", (joint,), {"level": x, "width": 0.1})
        for joint, x in zip(JOINTS[:2], (1e-6, 2e-6), strict=True)
    )
    assert [(c.change, c.joints, c.value) for c in file.changes] == [("stiffness", (JOINTS[1],), 1e-5)]


def test_a_proposed_experiment_reaches_the_robot_in_its_own_signs_and_limits(tmp_path):
    drives = np.column_stack([np.linspace(-150.0, 150.0, 400), np.full(400, 5.0)])
    leg = "fr"
    record = SimpleNamespace(step=1e3 / HZ, drives_per_reading=1)
    write_drives({leg: drives}, {leg: record}, tmp_path / "bag")
    with pytest.raises(BagError, match="holds no"):
        read(tmp_path / "bag")  # voltages alone, to be played
    from hamr_bags.bag import open_bag
    from hamr_bags.decode import decode_all
    from hamr_bags.frames import SERVO_NAMES
    from hamr_bags.topics import TRAJECTORY

    with open_bag(tmp_path / "bag") as bag:
        raws = bag.raws(Topic.SERVO_VOLTAGES)[1]
    volts = np.concatenate([n["effort"].reshape(-1, 8) for _, n in decode_all(raws, TRAJECTORY, SERVO_NAMES[Topic.SERVO_VOLTAGES])])
    assert len(volts) == 400 * 5
    between = np.interp(np.arange(2000) / 5, np.arange(400), drives[:, 0])  # a smooth signal stays smooth
    np.testing.assert_allclose(volts[:, 4], np.clip(112.5 + drive_sign(leg) * between, 0.0, 225.0))
    np.testing.assert_array_equal(np.delete(volts, [4, 5], axis=1), 112.5)


def job(number: int, tell) -> tuple[int, int]:
    """Its answer and the process that gave it."""
    tell("screen")
    if number < 0:
        raise BagError("no such number.")
    return number**2, os.getpid()


def test_machines_are_analysed_beside_each_other(capfd, monkeypatch):
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    results = side_by_side({str(number): partial(job, number) for number in (3, 4, 5)})
    assert {name: answer for name, (answer, _) in results.items()} == {"3": 9, "4": 16, "5": 25}
    assert os.getpid() not in {process for _, process in results.values()}
    assert "100 %" in capfd.readouterr().err
    with pytest.raises(BagError, match="no such number"):
        side_by_side({str(number): partial(job, number) for number in (3, -1)})
    monkeypatch.setattr(os, "cpu_count", lambda: 1)
    assert {process for _, process in side_by_side({"a": partial(job, 1), "b": partial(job, 2)}).values()} == {os.getpid()}


@pytest.fixture(scope="module")
def nameless():
    """A law without a name."""
    return oscillator(lambda q, v: -1500.0 * np.sin(3.0 * q) * np.exp(-((v / 40.0) ** 2)), noise=0.01)


def test_a_law_without_a_name_is_found_as_a_table(nameless):
    prepared = prepare(*nameless)
    found = fit_table(prepared, prepared.base)
    assert found.effects[0].effect == "force_table"
    assert found.left - 1.0 < 0.4 * (prepared.base.left - 1.0)


@pytest.fixture(scope="module")
def unknown(nameless):
    return analyse(*nameless)


@pytest.mark.parametrize("helps", [True, False])
def test_a_table_is_added_only_where_it_helps(nameless, unknown, monkeypatch, helps):
    """On readings that it was not fitted to: some left more there than the re-tuned model, and were added nevertheless."""

    def fitted(prepared, beside):
        found = fit_table(prepared, beside)
        return found if helps else replace(found, left=1.01 * prepared.base.left)

    monkeypatch.setattr("hamr_gap.answers.found.analyse", lambda *_: unknown)
    monkeypatch.setattr("hamr_gap.answers.found.fit_table", fitted)
    found = find(*nameless).verdict
    assert found["verdict"] == "unknown"
    assert [e["effect"] for e in found["added"]] == ["force_table"] * helps
    assert (found["gap"]["after"] < 0.7 * found["gap"]["retuned"]) == helps


def test_a_fit_that_comes_to_no_end_is_a_sentence(nameless, monkeypatch, tmp_path):
    machine, record = nameless
    monkeypatch.setattr("hamr_gap.answers.found.analyse", lambda *_: np.linalg.inv(np.zeros((2, 2))))
    with pytest.raises(BagError, match=f"The fits to {machine.name} did not come to an end .*another excitation"):
        stored(machine, record, tmp_path)
