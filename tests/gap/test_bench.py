"""Machines with a hidden effect in MuJoCo, found blind from 12 s (others are in test_bench_short.py); and how scores are counted."""

from __future__ import annotations

import csv
import json

import pytest
from smoke import NULLS, cases, is_found_and_placed, solved

from hamr_gap.bench import listing
from hamr_gap.bench.score import names, scored
from hamr_gap.bench.told import right_set, rows


@cases("single", seconds=12.0)
def test_a_hidden_effect_is_found_and_placed(case):
    is_found_and_placed(case)


@pytest.mark.parametrize("case", NULLS)
def test_where_nothing_is_hidden_nothing_is_found(case):
    assert solved(case).verdict.verdict in ("no_significant_gap", "parameters_only")


def test_names_are_families_at_places_in_any_order():
    assert names([["a", "x", ["l", "s"]], ["b", "y", ["s"]]]) == names([["b", "z", ["s"]], ["a", "x", ["s", "l"]]])


def test_the_right_set_has_what_noise_free_data_do_not_tell_apart_and_nothing_that_only_adds_to_it():
    def one(*effects):
        return [[effect, "", ["s"]] for effect in effects]

    truth = names(one("coulomb_friction"))
    rivals = [
        [one("coulomb_friction"), 0.5], [one("stribeck_friction"), 0.1], [one("coulomb_friction", "piezo_creep"), 0.2],
        [one("piezo_hysteresis"), 3.9], [one("viscoelasticity"), 4.1], [[], 100.0],
    ]  # fmt: skip
    assert right_set(truth, rivals) == {truth, names(one("piezo_hysteresis"))}
    assert right_set(truth, [[one("viscoelasticity"), 9.0]]) == {truth}
    places = {"coulomb_friction": (["s", "l"], ["l"]), "stribeck_friction": (["s", "l"],)}
    at_both, elsewhere, wider = ([[effect, "", joints]] for effect, places_of in places.items() for joints in places_of)
    assert right_set(truth, [[at_both, 0.4], [wider, 0.3], [elsewhere, 3.0]]) == {truth, names(elsewhere)}


def test_what_a_signal_could_tell_is_held_against_what_was_said_of_experiments(tmp_path):
    """Of four ambiguous answers two are decidable, one of which was settled by the run it asked for; of one of the others that was said."""
    lag, delay = ([[effect, "", ["fl_lift"]]] for effect in ("drive_lag", "drive_delay"))
    for name, signal, apart, second in ((1, "chirp", 9.0, lag), (2, "chirp", 4.1, delay), (3, "", 3.9, None), (4, "chirp", 0.0, None)):
        truth = {"group": "twins", "effects": [{"family": e, "law": f"law{name}", "joints": at} for e, _, at in lag]}
        weights = [{"effects": e, "probability": 0.5} for e in (lag, delay)]
        first = {"verdict": "ambiguous", "weights": weights, "experiment": {"signal": signal}}
        again = second and {"verdict": "named", "weights": [{"effects": second, "probability": 1.0}]}
        shown = {"chirp": 0.5 * apart, "steps that hold": apart}
        for folder, content in (("answers", truth), ("verdicts", first), ("verdicts_second", again), ("verdicts_decidable", shown)):
            (tmp_path / folder).mkdir(exist_ok=True)
            if content:
                (tmp_path / folder / f"{name}.json").write_text(json.dumps(content))
    found = dict(rows(tmp_path, [scored(tmp_path, name) for name in (1, 2, 3, 4)], "verdicts"))
    assert {what: text[:4] for what, text in found.items()} == {
        "ambiguous: settled by the run that was asked for": "50 %",
        "ambiguous and decidable (computed): settled by the run that was asked for": "50 %",
        "ambiguous and not decidable (computed): it was said that no experiment decides": "50 %",
    }


def test_every_case_has_a_line(tmp_path):
    """What was hidden, what was answered first and with what probability; nothing said to be missing, no first answer."""
    lag, play = ["drive_lag", "first_order", ["fl_lift"]], ["backlash", "dead_band", ["fl_swing", "fl_lift"]]
    cases = [
        (7, "pair", "ambiguous", [lag, play], [([lag], 0.6), ([lag, play], 0.35), (None, 0.05)]),
        (3, "null", "parameters_only", [], [(None, 0.1)]),
        (5, "outside", "unknown", [["outside", "cogging", ["fl_lift"]]], [(None, 0.99)]),
    ]  # fmt: skip
    for name, group, verdict, truth, weights in cases:
        effects = [{"family": e, "law": law, "joints": joints} for e, law, joints in truth]
        answer = {"group": group, "effects": effects, "reached": [5.12345, 3.0] if truth else [], "seconds": 12.0, "noise": 2e-4}
        found = [{"effects": effects, "probability": p} for effects, p in weights]
        for folder, content in (("answers", answer), ("verdicts", {"verdict": verdict, "weights": found, "best": 1.25, "seconds": 31.4})):
            (tmp_path / folder).mkdir(exist_ok=True)
            (tmp_path / folder / f"{name}.json").write_text(json.dumps(content))
    listing.write(tmp_path / "cases.csv", [scored(tmp_path, name) for name, *_ in cases])
    both, data = "backlash (fl_lift, fl_swing) + drive_lag (fl_lift)", ("12", "0.0002")
    with (tmp_path / "cases.csv").open(newline="") as file:
        lines = list(csv.reader(file))
    assert lines == [
        list(listing.COLUMNS),
        ["3", "null", "", "parameters_only", "", "", "1", "0", "1.250", "31", "", *data],
        ["5", "outside", "cogging (fl_lift)", "unknown", "unknown", "0.990", "1", "0", "1.250", "31", "5.123", *data],
        ["7", "pair", both, "ambiguous", "drive_lag (fl_lift)", "0.600", "0", "1", "1.250", "31", "5.123", *data],
    ]
