"""A smoke set of the benchmark: machines with a hidden effect in MuJoCo, found blind; and how scores are counted."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

import hidden_gap
from hamr_gap.analyse import analyse
from hamr_gap.bench.cases import LEG, samples_of
from hamr_gap.bench.score import names, rate
from hamr_gap.legs import machine_of, record_of
from hidden_gap.case import JOINTS, Case, Effect

CASES = json.loads(Path(__file__).with_name("cases.json").read_text())


def case_of(given: dict) -> Case:
    """A case that was drawn for development, its strength met."""
    effects = tuple(Effect(e["family"], tuple(e["joints"]), e["law"], e["parameters"]) for e in given["effects"])
    return Case(**{**given, "effects": effects, "channels": tuple(given["channels"])})


def record(case: Case):
    truth = hidden_gap.simulate(case)
    return record_of(samples_of(case, truth, hidden_gap.measured(case, truth)), LEG, JOINTS)


@pytest.mark.parametrize("given", CASES, ids=[c["effects"][0]["family"] for c in CASES])
def test_a_hidden_effect_is_found_and_placed(given):
    case = case_of(given)
    found = analyse(machine_of("simple", "fl"), record(case))
    assert found.verdict.verdict in ("named", "ambiguous")
    first = found.verdict.set[0]
    assert {(e.effect, tuple(sorted(e.joints))) for e in first.effects} == {(e.family, tuple(sorted(e.joints))) for e in case.effects}
    left = found.left(found.prepared.roles.report)
    assert left["best"] - left["floor"] < 0.2 * (left["base"] - left["floor"])  # on readings that nothing else has seen


@pytest.mark.parametrize("seed", [300_000, 300_001])
def test_where_nothing_is_hidden_nothing_is_found(seed):
    case = replace(hidden_gap.draw("null", seed), noise_kind="white")
    assert analyse(machine_of("simple", "fl"), record(case)).verdict.verdict in ("no_significant_gap", "parameters_only")


def test_names_are_families_at_places_in_any_order():
    assert names([["a", "x", ["l", "s"]], ["b", "y", ["s"]]]) == names([["b", "z", ["s"]], ["a", "x", ["s", "l"]]])


def test_shares_carry_exact_intervals():
    assert rate([True] * 10) == "100 % (69..100, n = 10)"  # Clopper-Pearson: 1 - 0.025^(1/10)
    assert rate([]) == "-"
