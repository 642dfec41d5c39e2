"""Probabilities from what hypotheses leave: the rules, on numbers made here."""

from __future__ import annotations

import re
from types import SimpleNamespace

import numpy as np
import pytest

from hamr_gap.fitting.parameters import Candidate
from hamr_gap.judging.weigh import UNKNOWN, weigh
from hamr_gap.naming.blocks import better, foreseen
from hamr_gap.naming.hypothesis import Hypothesis
from hamr_gap.naming.tried import Search


def weights(spread: float = 0.01, numbers: dict[str, int] | None = None, **left: float) -> dict[str, float]:
    """Probability of each name, at the first joint or, with _1, the second, where a gap of 100 times the noise is left to these shares.

    With _01 it is at both. spread: of what each leaves over blocks. numbers: sizes and shapes of names that have not two.
    """

    def one(names: str, share: float) -> SimpleNamespace:
        places = (re.fullmatch(r"(.+?)_?([01]*)", name).groups() for name in names.split("__"))
        effects = tuple(Candidate(name, FORMS[name], tuple(map(int, joints or "0"))) for name, joints in places)
        blocks = (1.0 + 100.0 * share) * (1.0 + spread * np.random.default_rng(len(names)).standard_normal(24))
        return SimpleNamespace(effects=effects, left=1.0 + 100.0 * share, blocks=blocks, parameters=(numbers or {}).get(names, 2))

    tried = {frozenset(c.name for c in h.effects): h for h in (one(*item) for item in left.items())}
    state = SimpleNamespace(base=SimpleNamespace(left=101.0), floor=1.0, count=10_000, by_names=lambda: tried)
    found = weigh(state)
    suffix = {(0,): "", (1,): "_1", (0, 1): "_01"}
    named = {"__".join(c.effect + suffix[c.joints] for c in w.hypothesis.effects) if w.hypothesis else "unknown": w for w in found}
    return {name: w.probability for name, w in named.items()}


FORMS = {"coulomb_friction": "sign", "stribeck_friction": "lorentzian", "drive_lag": "first_order", "cubic_stiffness": "cubic",
         "configuration_dependent_stiffness": "oblique", "drive_delay": "pade", "drive_drift": "heating"}  # fmt: skip


@pytest.mark.parametrize("left", [np.full(24, 0.02), np.r_[np.zeros(18), np.full(6, 0.2)], np.full(24, 3.0)])
def test_what_is_seen_throughout_is_foreseen(left):
    """t over blocks, as noise in the readings makes it: the median of many tries."""
    random, count = np.random.default_rng(4), 400
    noise = random.standard_normal((300, 24, count))
    worse = (noise + np.sqrt(left)[:, None] * np.sign(random.standard_normal(count))) ** 2
    seen = [better(w, b) for w, b in zip(worse.mean(2), (noise**2).mean(2), strict=True)]
    assert foreseen(left, np.full(24, count)) == pytest.approx(np.median(seen), rel=0.15)


def first(found: dict[str, float]) -> str:
    return max(found, key=found.get)


def test_probabilities_sum_to_one_and_less_left_is_likelier():
    found = weights(coulomb_friction=0.01, drive_lag=0.02, cubic_stiffness=0.5)
    assert np.isclose(sum(found.values()), 1.0)
    assert found["coulomb_friction"] > found["drive_lag"] > found["cubic_stiffness"]


def test_many_numbers_cost_something_but_no_more_than_they_can_explain():
    alike = weights(numbers={"cubic_stiffness": 50}, coulomb_friction=0.01, cubic_stiffness=0.01)
    assert 0.6 < alike["coulomb_friction"] < 0.9
    assert weights(numbers={"cubic_stiffness": 50}, coulomb_friction=0.03, cubic_stiffness=0.005)["cubic_stiffness"] > 0.95


def test_what_two_names_differ_by_is_known_better_than_the_noise():
    """The noise is known to a few per cent; what the best leaves is noise if it may be."""
    exact = weights(coulomb_friction=0.0, drive_lag=0.0005)["coulomb_friction"]
    assert exact > 0.98
    assert weights(coulomb_friction=0.0002, drive_lag=0.0007)["coulomb_friction"] == pytest.approx(exact, abs=1e-3)
    assert weights(coulomb_friction=0.01, drive_lag=0.0105)["coulomb_friction"] < 0.6  # laws that both miss something


def test_what_is_left_in_a_few_blocks_more_than_by_the_best_may_be_chance():
    """Up to the error of the noise."""
    assert weights(coulomb_friction=0.0, drive_lag=0.0003)["coulomb_friction"] > 0.95
    assert weights(0.1, coulomb_friction=0.0, drive_lag=0.0003)["coulomb_friction"] == pytest.approx(0.5, abs=0.01)
    assert weights(0.1, coulomb_friction=0.0, drive_lag=0.0013)["coulomb_friction"] > 0.95


def test_where_every_name_leaves_too_much_the_law_is_unknown():
    """Also where the name that leaves least pays for holding another."""
    assert first(weights(coulomb_friction=1.2 * UNKNOWN, drive_lag=0.5)) == "unknown"
    assert first(weights(stribeck_friction=1.5 * UNKNOWN, drive_lag=1.8 * UNKNOWN, cubic_stiffness=2.0 * UNKNOWN)) == "unknown"


def test_a_wider_name_that_leaves_little_keeps_the_law_known():
    found = weights(coulomb_friction=0.9 * UNKNOWN, stribeck_friction=0.4 * UNKNOWN)
    assert found["unknown"] < 0.1
    assert found["coulomb_friction"] > found["stribeck_friction"]  # the simpler name, until three nats speak against it


def test_a_second_effect_must_earn_its_place_but_does_not_make_the_law_unknown():
    single = weights(coulomb_friction=0.02, coulomb_friction__drive_lag=0.01)
    assert first(single) == "coulomb_friction"
    pair = weights(coulomb_friction=0.5, coulomb_friction__drive_lag=0.02)
    assert first(pair) == "coulomb_friction__drive_lag"
    assert pair["unknown"] < 0.02


def test_a_second_effect_that_takes_little_away_may_be_anything():
    """Both leave six times less than the first alone, of a large part of the gap and of a small one."""
    large = weights(coulomb_friction=0.06, coulomb_friction__drive_lag=0.01)
    small = weights(coulomb_friction=0.006, coulomb_friction__drive_lag=0.001)
    assert first(large) == "coulomb_friction__drive_lag" and first(small) == "coulomb_friction"


def test_a_name_that_leaves_most_of_the_gap_is_no_answer_where_two_at_both_joints_leave_next_to_nothing():
    """Though it costs nothing, and each of the two has a second place."""
    found = weights(drive_lag=0.4, drive_delay_1=0.7, drive_drift_01__drive_lag_01=0.011)
    assert found["drive_drift_01__drive_lag_01"] > 0.9
    assert weights(drive_lag=0.05, drive_drift_01__drive_lag_01=0.011)["drive_lag"] > 0.8  # that one might be


def test_a_name_that_leaves_more_than_any_right_one_is_no_answer_where_others_leave_little():
    """Two at both joints of a measured double pendulum left 3 % of the gap, and one that left 23 % came first, for it cost less."""
    pair = {"drive_drift_01__coulomb_friction_01": 0.034}
    found = weights(numbers=dict.fromkeys(pair, 10), cubic_stiffness=0.23, **pair)
    assert found["drive_drift_01__coulomb_friction_01"] > 0.95
    assert found["cubic_stiffness"] == 0.0
    assert weights(numbers=dict.fromkeys(pair, 10), cubic_stiffness=0.11, **pair)["cubic_stiffness"] > 0.3
    nothing = weights(cubic_stiffness=0.23, drive_drift_01__coulomb_friction_01=0.15)
    assert first(nothing) == "unknown"
    assert nothing["cubic_stiffness"] > nothing["drive_drift_01__coulomb_friction_01"] > 0.0  # where none does, it may be as well as any


def test_a_name_that_takes_next_to_nothing_away_is_no_answer_where_two_take_most():
    """However little it costs, and the two much: one of them holds simpler laws."""
    dear = {"configuration_dependent_stiffness__drive_lag": 8}
    found = weights(numbers=dear, drive_lag=0.995, configuration_dependent_stiffness__drive_lag=0.09)
    assert first(found) == "configuration_dependent_stiffness__drive_lag"
    assert found["drive_lag"] < 0.05


def test_a_name_must_leave_less_throughout_than_its_special_case():
    assert "stribeck_friction" not in weights(coulomb_friction=0.01, stribeck_friction=0.01)
    assert weights(coulomb_friction=0.01, stribeck_friction=0.0001)["stribeck_friction"] > 0.9
    assert "stribeck_friction_1" in weights(coulomb_friction=0.01, stribeck_friction_1=0.01)  # of another joint it is no case
    beside = weights(drive_lag=0.5, coulomb_friction__drive_lag=0.01, stribeck_friction__drive_lag=0.01)
    assert "coulomb_friction__drive_lag" in beside and "stribeck_friction__drive_lag" not in beside


def test_a_name_at_both_joints_must_leave_less_throughout_than_its_special_case_at_one_beside_itself_at_the_other():
    beside = "coulomb_friction__stribeck_friction_1"
    found = weights(coulomb_friction=0.3, stribeck_friction_01=0.01, **{beside: 0.01})
    assert beside in found and "stribeck_friction_01" not in found
    assert first(weights(coulomb_friction=0.3, stribeck_friction_01=0.0001, **{beside: 0.05})) == "stribeck_friction_01"


def test_a_name_at_both_joints_must_leave_less_throughout_than_at_one():
    """Also one that couples them and so counts as one place: a spring across both angles may lie along one of them."""
    for name in ("drive_lag", "configuration_dependent_stiffness"):
        assert f"{name}_01" not in weights(**{name: 0.01, f"{name}_01": 0.01})
        assert weights(**{name: 0.05, f"{name}_01": 0.0001})[f"{name}_01"] > 0.9


@pytest.mark.parametrize(("more", "in_blocks", "chosen"), [
    (1.06, 2, "presliding"),  # luck of two blocks
    (1.06, 24, "lugre"),  # a little, but throughout
    (1.001, 24, "presliding"),  # throughout, but less than further parameters must earn
    (1.5, 2, "lugre"),  # little is what may be luck
    (1.0, 24, "presliding"),
])  # fmt: skip
def test_of_forms_the_simplest_that_does_as_well_but_for_a_few_blocks(more, in_blocks, chosen):
    """How much more the simpler one leaves on the whole, and in how many of 24 blocks."""
    blocks = 1.0 + 0.02 * np.random.default_rng(5).standard_normal(24)
    worse = blocks.copy()
    worse[:in_blocks] += (more - 1.0) * 24 / in_blocks

    def tried(form: str, blocks: np.ndarray) -> Hypothesis:
        return Hypothesis((Candidate("coulomb_friction", form, (0,)),), None, float(blocks.mean()), blocks)

    for several in ([tried("presliding", worse), tried("lugre", blocks)], [tried("lugre", blocks), tried("presliding", worse)]):
        (found,) = Search(None, None, None, 10_000, several).by_names().values()
        assert found.effects[0].form == chosen
