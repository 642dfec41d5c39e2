"""Answers of machines that are built alike."""

from __future__ import annotations

import numpy as np
import pytest

from hamr_description.names import LEGS
from hamr_gap.answers.answer import answer
from hamr_gap.answers.found import Found
from hamr_gap.answers.together import ALIKE, together

LEVER, BOTH, LAG = ("lever",), ("lever", "inertia"), ("lag",)


def found(leg: str, inside: int, *answers: tuple[tuple[str, ...], float]) -> Found:
    """A leg's answers, of which the first `inside` are its set; the k-th one's parameters, gap and rows are k."""
    every = [
        {
            "effects": [{"effect": name, "form": "any", "joints": [f"{leg}_lift"], "parameters": {}} for name in names],
            "probability": p, "left": 0.0, "forms": {}, "unknown": False, "gap": gap(k),
            "parameters": {"stiffness": {f"{leg}_lift": {"value": k}}},
        }
        for k, (names, p) in enumerate(answers)
    ]  # fmt: skip
    word = "no_significant_gap" if not answers else "named" if inside == 1 else "ambiguous"
    first = every[0] if every else {"effects": [], "parameters": {}, "gap": gap(0)}
    verdict = {
        "joints": [f"{leg}_swing", f"{leg}_lift"], "verdict": word, "set": every[:inside], "added": first["effects"],
        "parameters": {}, "gap": first["gap"], "not_observable": {}, "where": [], "notes": [], "experiment": None,
    }  # fmt: skip
    arrays = {"rows.raw": np.array(-1), "rows.after": np.array(0)} | {f"rows.after.{k}": np.array(k) for k in range(len(every))}
    return Found(verdict, [], {}, arrays, every)


def gap(k: int) -> dict:
    return {"raw": 3.0, "retuned": 2.0, "after": float(k), "floor": 1.0, "per_channel": {}}


def test_what_every_leg_finds_credible_is_everyones_answer():
    own = [(BOTH, 0.6), (LEVER, 0.38)], [(BOTH, 0.85), (LEVER, 0.14)], [(LEVER, 0.52), (BOTH, 0.46)], [(BOTH, 0.94), (LEVER, 0.05)]
    founds = {leg: found(leg, 2, *answers) for leg, answers in zip(LEGS, own, strict=True)}
    led, combinations = together(founds)
    assert [combinations[0].numbers[leg] for leg in LEGS] == [0, 0, 1, 0]
    both, lever = 0.6 * 0.85 * 0.46 * 0.94, 0.38 * 0.14 * 0.52 * 0.05
    alike = ALIKE * (both + lever) / (ALIKE * (both + lever) + 1.0 - both - lever)
    assert combinations[0].probability == pytest.approx(alike * both**0.25 / (both**0.25 + lever**0.25))
    third = led[LEGS[2]]
    assert [e["effect"] for e in third.verdict["added"]] == ["lever", "inertia"]
    assert [len(a["effects"]) for a in third.verdict["set"]] == [2, 1]
    assert (third.verdict["parameters"]["stiffness"][f"{LEGS[2]}_lift"]["value"], third.verdict["gap"]["after"]) == (1, 1.0)
    assert (third.arrays["rows.after"], third.arrays["rows.raw"]) == (1, -1)
    assert led[LEGS[0]] is founds[LEGS[0]]
    whole = answer(led, combinations)
    assert whole["verdict"] == "ambiguous"
    assert [(e["effect"], e["place"]) for e in whole["set"][0]["effects"]] == [("lever", "lift"), ("inertia", "lift")]


def test_other_legs_speak_for_what_one_finds_improbable_but_not_what_it_refutes():
    sure, doubtful = [(BOTH, 0.9), (LEVER, 0.08)], [(LEVER, 0.96), (BOTH, 0.02)]
    founds = {leg: found(leg, 1, *(doubtful if leg == "rr" else sure)) for leg in LEGS}
    led, _ = together(founds)
    assert [len(f.verdict["added"]) for f in led.values()] == [2, 2, 2, 2]
    assert led["rr"].verdict["verdict"] == "ambiguous"
    led, combinations = together(founds | {"rr": found("rr", 1, (LEVER, 0.999))})
    assert [len(led[leg].verdict["added"]) for leg in ("fl", "rr")] == [2, 1]
    assert len(combinations) > 1


def test_legs_that_are_sure_of_different_things_keep_them():
    founds = {"fl": found("fl", 1, (LAG, 0.9999)), "rl": found("rl", 1, (LEVER, 0.9995), (LAG, 0.0001))}
    led, combinations = together(founds)
    assert led == founds
    assert combinations[0].probability == pytest.approx(0.99, abs=0.01)
    assert answer(led, combinations)["verdict"] == "named"


def test_a_leg_that_misses_nothing_is_not_like_the_others():
    founds = {"fl": found("fl", 2, (LAG, 0.6), (LEVER, 0.35)), "rl": found("rl", 2, (LEVER, 0.55), (LAG, 0.4)), "fr": found("fr", 0)}
    led, combinations = together(founds)
    assert led == founds
    assert [c.probability for c in combinations][0] == pytest.approx(0.33)
