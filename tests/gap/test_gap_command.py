"""`hamr gap` on bags of one leg with hidden friction: it names it, writes a model that has it, and proves that on data never used."""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from leg_bags import LEG, record, write

from hamr_bags.bag import open_bag
from hamr_bags.decode import decode_all
from hamr_bags.topics import JOINT_STATE
from hamr_bringup.cli import run
from hamr_dynamics.effects import effects_file
from hamr_gap.answers.found import Found
from hamr_gap.data.measured import read
from hamr_sim_residual.engines import make_engine

JOINTS = (f"{LEG}_swing", f"{LEG}_lift")
LEVEL = 4e-6  # N m
HIDDEN = effects_file.EffectsFile(
    (effects_file.PlacedEffect("coulomb_friction", "presliding", (JOINTS[1],), {"level": LEVEL, "distance": 0.02}),),
    (effects_file.Change("damping", (JOINTS[0],), 8e-9),),
)


def gap(capfd, *words: str | Path) -> tuple[int, dict]:
    """Exit status and the JSON object of `hamr gap`, the only thing on standard output."""
    capfd.readouterr()
    status = run(["gap", "--backend", "simple", "--json", *map(str, words)])
    return status, json.loads(capfd.readouterr().out)


@pytest.fixture(scope="module")
def bags(tmp_path_factory) -> SimpleNamespace:
    """A run to learn from and one of another kind to hold out; no field but angles, deflections and voltages."""
    folder = tmp_path_factory.mktemp("gap")
    effects_file.write(HIDDEN, folder / "hidden.yaml")
    runs = {
        "measured": record(folder / "all", str(folder / "hidden.yaml"), seconds=4.0, seed=1),
        "holdout": record(folder / "more", str(folder / "hidden.yaml"), seconds=2.0, seed=2, kind="mix"),
    }
    paths = {name: write(folder / name, x, noise=0.01, seed=7, joints=JOINTS) for name, x in runs.items()}
    return SimpleNamespace(folder=folder, runs=runs, **paths)


@pytest.fixture(scope="module")
def answer(bags) -> dict:
    """What the command finds; one of the measured bags is missing."""
    from hamr_gap.gap import run as study

    return study([bags.measured, bags.folder / "nowhere"], bags.folder / "out", backend="simple", holdout=[bags.holdout])


def test_it_names_the_friction_and_its_place(answer):
    assert answer["verdict"] == "named"
    (first,) = answer["set"]
    (effect,) = first["effects"]
    assert (effect["effect"], effect["place"]) == ("coulomb_friction", JOINTS[1])
    assert first["probability"] > 0.9
    assert effect["parameters"]["level"]["unit"] == "N*m"
    assert effect["parameters"]["level"]["value"] == pytest.approx(LEVEL, rel=0.1)


def test_a_bag_that_cannot_be_read_is_said_and_left_out(answer, bags):
    assert list(answer["refused"]) == [str(bags.folder / "nowhere")]
    assert answer["refused"][str(bags.folder / "nowhere")].startswith("There is no bag at")


def test_the_gap_closes_on_data_never_used_and_comes_back_without_the_effect(answer):
    over = answer["shown"]["over_floor"]
    assert over["raw"] > over["retuned"] > 3.0
    assert over["after"] < 0.3 * over["retuned"]
    assert answer["shown"]["closed"] > 0.95
    assert over["removed"] > 3.0 * over["after"]
    for horizon in answer["shown"]["horizons"].values():
        assert horizon["after"] < horizon["retuned"]


def test_the_answer_was_fixed_before_the_rest_was_opened(answer, bags):
    out = bags.folder / "out"
    digest, name = (out / "verdict.sha256").read_text().split()
    fixed = (out / name).read_bytes()
    assert hashlib.sha256(fixed).hexdigest() == digest
    assert "shown" not in json.loads(fixed)
    assert json.loads((out / "verdict.json").read_text()).items() >= json.loads(fixed).items()


def test_the_effects_file_closes_the_gap_of_the_whole_robot(answer, bags):
    """Through the engine behind the topics, which knows nothing of the workflow."""
    truth, rms = bags.runs["holdout"], {}
    for name, effects in (("without", ""), ("with", answer["effects_file"])):
        engine = make_engine(backend="simple", environment="suspended", effects=effects)
        sample, angles = np.empty((7, 8)), []
        for volts in truth.voltages:
            engine.measure(sample)
            angles.append(sample[0].copy())
            for _ in range(5):  # 20 kHz under samples at 4 kHz, held
                engine.substep(volts)
        columns = [6, 7]  # of the rear right leg
        rms[name] = np.sqrt(np.mean((np.array(angles) - truth.angles)[:, columns] ** 2))
    assert rms["with"] < 0.2 * rms["without"]


def test_the_report_needs_no_network(answer):
    html = Path(answer["report"]).read_text()
    assert "coulomb_friction" in html
    assert html.count("<img") >= 5
    assert not re.findall(r"(?:src|href)\s*=\s*['\"](?!data:)", html)
    assert "<script" not in html


def test_the_overlay_holds_what_was_measured_and_simulated_in_the_robots_signs(answer, bags):
    series = {}
    with open_bag(answer["overlay"]) as bag:
        for topic in ("/measured/joint_states", "/simulated/joint_states"):
            raws = [message.raw for message in bag.messages([topic])]
            series[topic] = np.concatenate([numbers["position"] for _, numbers in decode_all(raws, JOINT_STATE, JOINTS)])
    measured = read(bags.holdout).angles
    means = measured[: len(measured) // 4 * 4].reshape(-1, 4, 2).mean(1)
    np.testing.assert_allclose(series["/measured/joint_states"], means, atol=1e-6)
    assert np.std(series["/simulated/joint_states"] - means) < 0.05 * np.std(means)


def test_what_only_a_simulation_knows_changes_nothing(answer, bags, capfd, monkeypatch):
    """A bag full of it, scrambled, is the same data to the byte: what was found before is found again without any analysis."""
    random, columns = np.random.default_rng(0), [6, 7]
    junk = {name: random.normal(size=bags.runs["measured"].angles[:, columns].shape) for name in ("velocities", "accelerations", "effort")}
    info = {"backend": "full", "seed": 99, "effects": [{"effect": "backlash"}], "parameters_hash": "0" * 16}
    other = write(bags.folder / "scrambled", bags.runs["measured"], noise=0.01, seed=7, joints=JOINTS, info=info, **junk)
    monkeypatch.setattr("hamr_gap.answers.found.analyse", lambda *_: pytest.fail("analysed again"))
    status, again = gap(capfd, "--measured", other, "--holdout", bags.holdout, "--out", bags.folder / "out")
    assert status == 0
    same = [name for name in answer if name not in ("command", "refused")]
    assert {name: again[name] for name in same} == {name: answer[name] for name in same}


def test_an_interrupted_run_goes_on_where_it_was(answer, bags, monkeypatch):
    from hamr_gap.gap import run as study

    folder = bags.folder / "out" / "found" / f"simple_{LEG}"
    key = json.loads((folder / "found.json").read_text())["key"]
    whole = Found.load(folder, key)
    assert whole.verdict["verdict"] == "named"
    assert Found.load(folder, "other data") is None
    first, *_ = whole.answers
    assert {name: x for name, x in first.items() if name not in ("parameters", "gap")} == whole.verdict["set"][0]
    assert {name: first[name] for name in ("parameters", "gap")} == {name: whole.verdict[name] for name in ("parameters", "gap")}
    np.testing.assert_array_equal(whole.arrays["rows.after.0"], whole.arrays["rows.after"])

    class Reached(Exception):
        """It began the analysis anew."""

    def analyse(*_):
        raise Reached

    monkeypatch.setattr("hamr_gap.answers.found.analyse", analyse)
    half = bags.folder / "half"
    whole.save(half / "found" / folder.name, key)
    (half / "found" / folder.name / "found.npz").write_bytes((folder / "found.npz").read_bytes()[:500])
    with pytest.raises(Reached):
        study([bags.measured], half, backend="simple")
    whole.save(half / "found" / folder.name, key)
    assert study([bags.measured], half, backend="simple")["verdict"] == "named"


def test_same_input_same_verdict(answer, bags):
    from hamr_gap.gap import run as study

    again = study([bags.measured], bags.folder / "again", backend="simple", holdout=[bags.holdout])
    same = [name for name in answer if name not in ("command", "refused", "effects_file", "report", "overlay")]
    assert json.dumps({name: again[name] for name in same}) == json.dumps({name: answer[name] for name in same})


def silent(run):
    """The run with a drive that does nothing."""
    voltages = run.voltages.copy()
    voltages[:, 7] = voltages[0, 7]
    return SimpleNamespace(voltages=voltages, angles=run.angles, deflections=run.deflections)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda path, run: path, "There is no bag at"),
        (lambda path, run: write(path, run, noise=0.01, seed=0, joints=JOINTS[:1]), "no leg with voltages and angles of both its joints"),
        (lambda path, run: write(path, run, noise=0.01, seed=0, joints=JOINTS, info={"servo_hz": 0}), "rates"),
        (lambda path, run: write(path, silent(run), noise=0.01, seed=0, joints=JOINTS), f"The drive of {JOINTS[1]} is constant"),
    ],
)
def test_bad_bags_are_one_sentence(make, says, bags, tmp_path, capfd):
    bag = make(tmp_path / "bag", bags.runs["holdout"])
    status, result = gap(capfd, "--measured", bag, "--out", tmp_path / "out")
    assert status == 1
    assert result["ok"] is False
    assert says in result["error"]
    assert re.sub(r"\S*/\S*|\d\.\d", "", result["error"]).count(". ") == 0, result["error"]


def test_what_is_measured_cannot_be_held_out(bags, tmp_path, capfd):
    """The gap would close on data that the answer was fitted to."""
    own = bags.measured.parent / "." / bags.measured.name
    status, result = gap(capfd, "--measured", bags.measured, "--holdout", own, "--out", tmp_path / "out")
    assert (status, result["ok"]) == (1, False)
    assert "is both measured and held out" in result["error"]
    assert not (tmp_path / "out").exists()


def test_a_missing_hold_out_bag_is_said_before_anything_is_done(bags, tmp_path, capfd):
    status, result = gap(capfd, "--measured", bags.measured, "--holdout", tmp_path / "none", "--out", tmp_path / "out")
    assert (status, result["ok"]) == (1, False)
    assert not (tmp_path / "out").exists()
