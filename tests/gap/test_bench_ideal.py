"""What noise-free data could tell at best, on a delay: the generator's ring buffer against the library's form of it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from hamr_gap.bench import decidable as decidable_module
from hamr_gap.bench.cases import from_plain
from hamr_gap.bench.decidable import decidable
from hamr_gap.bench.ideal import ideal, truth_of
from hamr_gap.bench.score import names
from hamr_gap.bench.told import TOLD_APART, right_set
from hamr_gap.experiments.apart import shapes
from hidden_gap.simulate import SAMPLE_HZ

DELAY = 1  # which of the cases has nothing but a delay, of one joint
SECONDS = 3.0  # as short as shows it


@pytest.fixture(scope="module")
def case():
    drawn = from_plain(json.loads(Path(__file__).with_name("cases.json").read_text())[DELAY])
    return replace(drawn, seconds=SECONDS, excitation=drawn.excitation | {"seconds": SECONDS})


@pytest.fixture(scope="module")
def found(case):
    return ideal(case)


def test_the_truth_is_nearest_and_all_others_are_told_apart(case, found):
    truth = names((e.family, e.law, e.joints) for e in case.effects)
    distances = [d for _, d in found["rivals"]]
    assert distances == sorted(distances)
    by_names = {names(effects): d for effects, d in found["rivals"]}
    assert by_names[truth] < TOLD_APART
    assert right_set(truth, found["rivals"]) == {truth}


def test_the_re_tuned_model_is_as_far_off_as_the_strength_says(case, found):
    """Strength is in floors of one reading, d' in noise of all: of one channel at least, and of all four at most."""
    by_names = {names(effects): d for effects, d in found["rivals"]}
    of_one_channel = case.strength * (SECONDS * SAMPLE_HZ) ** 0.5
    assert of_one_channel < by_names[frozenset()] < 2.0 * of_one_channel


def test_the_right_form_has_the_generators_own_size(case, found):
    (effect,), (form,) = case.effects, found["forms"].values()
    size = form[0]["parameters"]["delay"][effect.joints[0]]
    assert size["value"] == pytest.approx(1e-3 * effect.parameters["tau"], rel=2e-3)


def test_a_signal_tells_a_delay_from_a_lag_and_nothing_from_itself(case, monkeypatch):
    """As the hidden machine itself shows it: a delay of 0.9 ms and its nearest lag, under fast noise."""
    monkeypatch.setattr(decidable_module, "PLAYED_S", 1.0)
    monkeypatch.setattr(decidable_module, "shapes", lambda *given: {"fast noise": shapes(*given)["fast noise"]})
    truth = truth_of(case)
    lag = frozenset(("drive_lag", joints) for _, joints in truth)
    assert decidable(case, [lag])["fast noise"] > 20.0 * TOLD_APART
    assert decidable(case, [lag, truth])["fast noise"] == 0.0
