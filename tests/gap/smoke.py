"""The smoke set of the benchmark: twenty cases that were drawn for development, their strength met; simulated, they are records."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

import hidden_gap
from hamr_gap.bench.cases import LEG, from_plain, recorded, samples_of
from hamr_gap.data.record import Record
from hamr_gap.judging.analyse import Analysis, analyse
from hamr_gap.legs import machine_of, record_of
from hidden_gap.case import JOINTS, Case

CASES = [from_plain(c) for c in json.loads(Path(__file__).with_name("cases.json").read_text())]
NULLS = [replace(hidden_gap.draw("null", seed), noise_kind="white") for seed in (300_000, 300_001)]


def cases(*groups: str, seconds: float) -> pytest.MarkDecorator:
    """Those of some groups that are as long, called by what is hidden."""
    chosen = [c for c in CASES if c.group in groups and c.seconds == seconds]
    return pytest.mark.parametrize("case", chosen, ids=[" + ".join(e.law for e in c.effects) or c.noise_kind for c in chosen])


def solved(case: Case) -> Analysis:
    """The answer to a case, from what its sensors show."""
    truth = hidden_gap.simulate(case)
    record: Record = record_of(samples_of(case, truth, hidden_gap.measured(case, truth), recorded(case, truth)), LEG, JOINTS)
    return analyse(machine_of("simple", LEG), record)


def is_found_and_placed(case: Case) -> None:
    """What is hidden comes first, and closes the gap on readings that nothing else has seen."""
    found = solved(case)
    assert found.verdict.verdict in ("named", "ambiguous")
    first = found.verdict.set[0]
    assert {(e.effect, tuple(sorted(e.joints))) for e in first.effects} == {(e.family, tuple(sorted(e.joints))) for e in case.effects}
    left = found.left(found.prepared.roles.report)
    assert left["best"] - left["floor"] < 0.2 * (left["base"] - left["floor"])
