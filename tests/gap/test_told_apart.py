"""Names of an ambiguous answer, weighed by all readings: the rules, on numbers made here."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from hamr_gap.fitting.parameters import Candidate
from hamr_gap.judging import told_apart as module
from hamr_gap.judging.told_apart import by_all, told_apart
from hamr_gap.judging.weigh import Weight, weigh
from hamr_gap.naming.hypothesis import Hypothesis
from hamr_gap.naming.tried import Search

HELD, FITTED, BLOCKS = 3000, 6000, 24
WEIGHED, JUDGED = SimpleNamespace(chosen=np.ones((FITTED, 1), bool)), np.ones((HELD, 1), bool)
LAG, DELAY, SATURATION = Candidate("drive_lag", "first_order", (0,)), Candidate("drive_delay", "pade", (0,)), Candidate(
    "drive_saturation", "soft", (0,))  # fmt: skip


@pytest.fixture(autouse=True)
def fitted(monkeypatch):
    """What a fit leaves of the readings it was fitted to, in the place of readings."""
    monkeypatch.setattr(module, "left_of", lambda _, __, reading: (float(np.mean(reading)), np.asarray(reading, float)))


def hypothesis(effects: tuple[Candidate, ...], held: float, fitted: float | np.ndarray) -> Hypothesis:
    """One that leaves so much of the readings held out, and of those fitted, in each block or the same in all."""
    scatter = 1.0 + 0.002 * np.random.default_rng([len(c.form) for c in effects]).standard_normal(BLOCKS)
    return Hypothesis(effects, SimpleNamespace(reading=fitted * scatter), held, held * scatter)


def again(*tried: Hypothesis) -> tuple[list[Weight], list[Weight]]:
    """Weights by the readings held out, and again by all."""
    state = Search(None, hypothesis((), 6.0, 6.0), None, HELD, list(tried), floor=1.0)
    weights = weigh(state)
    return weights, told_apart(WEIGHED, JUDGED, state, weights)


def shares(weights: list[Weight]) -> dict[str, float]:
    return {" + ".join(c.effect for c in w.hypothesis.effects) if w.hypothesis else "unknown": w.probability for w in weights}


def test_what_the_fitted_readings_tell_apart_throughout_is_told_apart():
    before, after = map(shares, again(hypothesis((LAG,), 1.0, 1.0), hypothesis((DELAY,), 1.0, 1.06)))
    assert before["drive_lag"] == pytest.approx(before["drive_delay"])
    assert after["drive_lag"] > 0.98
    assert sum(after.values()) == pytest.approx(1.0)
    assert after["unknown"] == pytest.approx(before["unknown"])


def test_what_is_told_apart_is_told_once():
    """As sure as readings held out make it that are as many as both together, however sure a part of them was already."""
    _, after = map(shares, again(hypothesis((LAG,), 1.0, 1.0), hypothesis((DELAY,), 1.003, 1.003)))
    state = Search(None, hypothesis((), 6.0, 6.0), None, HELD + FITTED, [hypothesis((LAG,), 1.0, 1.0), hypothesis((DELAY,), 1.003, 1.003)])
    assert 0.7 < after["drive_lag"] < 0.95
    assert after["drive_lag"] == pytest.approx(shares(weigh(state))["drive_lag"], abs=0.01)


def test_what_a_law_misses_in_a_few_blocks_decides_nothing():
    few = np.where(np.arange(BLOCKS) < 2, 2.0, 1.0)
    before, after = map(shares, again(hypothesis((LAG,), 1.0, 1.0), hypothesis((DELAY,), 1.0, few)))
    assert after == pytest.approx(before)


def test_all_readings_may_say_the_opposite_of_those_held_out():
    before, after = map(shares, again(hypothesis((LAG,), 1.004, 1.0), hypothesis((DELAY,), 1.0, 1.06)))
    assert before["drive_lag"] < before["drive_delay"]
    assert after["drive_lag"] > 0.95


def test_who_has_one_name_or_a_sure_one_is_left_alone():
    before, after = again(hypothesis((LAG,), 1.0, 1.0), hypothesis((DELAY,), 1.5, 1.0))
    assert len([w for w in before if w.probability > 0.1]) == 1
    assert after == before


def test_names_that_are_not_in_the_set_keep_what_they_have():
    before, after = map(shares, again(*(hypothesis((c,), *left) for c, *left in (
        (LAG, 1.0, 1.0), (DELAY, 1.0, 1.06), (SATURATION, 1.2, 1.0)))))  # fmt: skip
    assert 0.0 < before["drive_saturation"] < 0.1
    assert after["drive_saturation"] == before["drive_saturation"]


def test_each_number_pays_for_what_chance_lets_it_take():
    """Of k numbers fitted to white noise in n readings k / n is taken away, and of others they leave as much more."""
    gain = Candidate("sensor_nonlinearity", "curve", (0,))
    many = hypothesis((gain,), 1.0, 1.0)
    random, n = np.random.default_rng(3), FITTED
    noise, basis = random.standard_normal((2, n)), np.linalg.qr(random.standard_normal((n, many.parameters)))[0]
    seen, unseen = (float(np.mean((x - basis @ (basis.T @ noise[0])) ** 2)) for x in noise)
    told = by_all(WEIGHED, JUDGED, hypothesis((gain,), unseen, seen / hypothesis((gain,), 1.0, 1.0).fit.reading.mean()))
    assert told.left == pytest.approx((HELD * unseen + FITTED * (seen + 2.0 * many.parameters / n)) / (HELD + FITTED), abs=1e-4)
    assert len(told.blocks) == 2 * BLOCKS


def test_of_a_name_the_form_is_taken_that_does_best_by_all():
    """A simple form does as well where nobody was looking, and a richer one explains what was fitted, too."""
    simple, rich = (hypothesis((Candidate("coulomb_friction", form, (0,)),), 1.0, x) for form, x in (("sign", 1.06), ("lugre", 1.0)))
    stribeck = hypothesis((Candidate("stribeck_friction", "lugre", (0,)),), 1.0, 1.03)
    before, after = again(simple, rich, stribeck, hypothesis((LAG,), 1.0, 1.06))
    assert next(w.hypothesis for w in before if w.hypothesis.effects[0].effect == "coulomb_friction") is simple
    assert after[0].hypothesis is rich
    assert after[0].left == pytest.approx(0.0, abs=1e-9)
