"""Moves of the search that add, on one leg of HAMR-simple with friction in its swing joint."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from shaken_leg import BESIDE, FRICTION, shaken

from hamr_gap.fitting import threads
from hamr_gap.fitting.fit import fit
from hamr_gap.fitting.parameters import Candidate, effect_parameters
from hamr_gap.legs import machine_of
from hamr_gap.naming import single_effects
from hamr_gap.naming.hypothesis import Start, refine, refined
from hamr_gap.naming.moves import ALONE, apart, at_both, from_elsewhere, look, pairs_of, promising, singles
from hamr_gap.naming.prepare import prepare
from hamr_gap.naming.tried import Search


def test_thresholds_found_at_each_joint_are_tried_together():
    """Drives that clip at 65 and 45 V: neither joint's limit alone explains it, nor one limit for both."""
    record = shaken("drive_saturation.hard", {"sharpness.0": 1 / 65.0, "sharpness.1": 1 / 45.0})
    clipped = prepare(machine_of("simple", "fl"), record)
    unit = clipped.weighed.model.scales.drive
    alone = []
    for joint, limit in ((0, 60.0), (1, 50.0)):
        c = Candidate("drive_saturation", "hard", (joint,))
        free = (*clipped.base.fit.free, *effect_parameters((c,), clipped.weighed.model.scales))
        start = Start((c,), free, np.array([*clipped.base.fit.x, unit / limit]), np.inf)
        alone.append(refine(clipped.weighed, clipped.judged, start))
    (both,) = at_both(clipped.weighed, clipped.judged, alone)
    assert both.effects == (Candidate("drive_saturation", "hard", (0, 1)),)
    assert both.left < 1.1 < 2.0 < min(h.left for h in alone)
    limits = {f.row: unit / x for f, x in zip(both.fit.free, both.fit.x, strict=True)}
    assert limits["drive_saturation.hard.sharpness.0"] == pytest.approx(65.0, rel=0.02)
    assert limits["drive_saturation.hard.sharpness.1"] == pytest.approx(45.0, rel=0.02)


def test_limits_between_those_that_were_seen_are_where_starts_look_for_them():
    """Limits between sizes of which one does nothing, or too little, and the next far too much; of one side each."""
    rms = float(np.std(shaken("drive_saturation.sides", {}).drives))
    limits = {"upper.0": 2.3 * rms, "lower.1": 2.1 * rms}
    clipped = prepare(machine_of("simple", "fl"), shaken("drive_saturation.sides", {name: 1.0 / x for name, x in limits.items()}))
    c, unit = Candidate("drive_saturation", "sides", (0, 1)), clipped.weighed.model.scales.drive
    seen = look(clipped.weighed, clipped.base.fit, [c])
    start = min(singles(clipped.weighed, clipped.base.fit, seen, [c]), key=lambda s: s.cost)
    assert start.cost < 0.2 * clipped.base.fit.cost
    found = {f.row: unit / x for f, x in zip(start.free, start.x, strict=True) if "sides" in f.row and x}
    assert found == pytest.approx({f"drive_saturation.sides.{name}": x for name, x in limits.items()}, rel=0.02)
    for k in [k for k, column in enumerate(seen.columns) if column.row.endswith(tuple(limits))]:
        sizes = [seen.size_of(k, share) for share in np.linspace(0.0, 1.0, 6)]
        assert sizes[-1] == seen.columns[k].size and (np.diff(sizes) > 0.0).all()


def test_a_valley_at_the_end_of_the_travel_is_seen_there(rubbing):
    """A fit that begins in the middle of the travel may end at a wide hill."""
    scale = rubbing.weighed.model.scales.coordinate
    valley = {"stiffness.0": 0.2, "centre.0": 2.0 * scale, "width.0": 0.5 * scale}
    edge = prepare(machine_of("simple", "fl"), shaken("configuration_dependent_stiffness.valley", valley))
    c = Candidate("configuration_dependent_stiffness", "valley", (0,))
    begun = singles(edge.weighed, edge.base.fit, look(edge.weighed, edge.base.fit, [c]), [c])
    best = refine(edge.weighed, edge.judged, min(begun, key=lambda start: start.cost))
    assert best.left < 1.2 < 0.1 * edge.base.left
    centre = dict(zip((f.row for f in best.fit.free), best.fit.x, strict=True))["configuration_dependent_stiffness.valley.centre.0"]
    assert centre * edge.weighed.model.scales.coordinate == pytest.approx(2.0 * scale, rel=0.1)


def test_only_what_the_linear_picture_likes_is_simulated_alone_but_all_of_it_in_pairs(rubbing, monkeypatch):
    everything = (*BESIDE, FRICTION, replace(FRICTION, form="sign"))
    seen = look(rubbing.weighed, rubbing.base.fit, everything)
    alone = {}
    for count in (1, 3):
        monkeypatch.setattr("hamr_gap.naming.moves.LIKED", count)
        alone[count] = singles(rubbing.weighed, rubbing.base.fit, seen, everything)
    assert {s.effects[0].name for s in alone[1]} == {FRICTION.name}
    assert {s.effects[0] for s in alone[3]} == set(everything)
    own = [s.cost for s in alone[3] if s.effects[0].name == FRICTION.name]
    assert [s.cost for s in alone[1]] == pytest.approx(own, rel=1e-9)  # what is left out changes nothing for the others
    state = Search(rubbing.weighed, rubbing.base, seen, int(rubbing.judged.sum()))
    pairs = pairs_of(rubbing.weighed, rubbing.judged, state, everything, alone[1])
    assert {frozenset(c.name for c in h.effects) for h in pairs} >= {frozenset({FRICTION.name, c.name}) for c in BESIDE}


def test_starts_far_worse_than_the_best_are_not_fitted():
    starts = [Start((c,), (), np.zeros(0), cost) for c, cost in ((FRICTION, 1.0), (BESIDE[0], 0.99 * ALONE), (BESIDE[1], 1.01 * ALONE))]
    assert promising(starts, ALONE) == starts[:2]


def test_what_leaves_least_is_fitted_from_all_its_starts(monkeypatch):
    """A soft place in the travel was fitted from the worse of two centres, and left 4 % of the gap; from the other it leaves nothing."""
    monkeypatch.setattr("hamr_gap.naming.moves.NAMES", 1)
    monkeypatch.setattr("hamr_gap.naming.moves.refined", lambda weighed, judged, wanted, known: [*wanted, *known])
    sign, play = replace(FRICTION, form="sign"), replace(FRICTION, effect="backlash", form="dead_band")
    alone = [Start((c,), (), np.zeros(0), cost) for cost, c in enumerate((play, play, FRICTION, sign, FRICTION))]
    tried = [SimpleNamespace(effects=(c,), left=left) for c, left in ((FRICTION, 1.0), (play, 2.0))]
    *wanted, known = from_elsewhere(None, None, alone, tried)
    assert wanted == alone[3:]
    assert known is tried[0]


@pytest.mark.parametrize(("names", "families", "effects"), [(2, 1, "a"), (2, 2, "ab"), (3, 2, "ab"), (5, 2, "abc")])
def test_places_of_one_effect_crowd_no_other_out(monkeypatch, names, families, effects):
    """Of a structural damping eight to ten names at one joint or both began better, so that it was not fitted."""
    monkeypatch.setattr(single_effects, "SINGLES", names)
    monkeypatch.setattr(single_effects, "FAMILIES", families)
    ordered = [replace(FRICTION, effect=effect, joints=at) for effect in "abc" for at in ((0,), (0, 1))]
    starts = [Start((c,), (), np.zeros(0), cost) for cost, c in enumerate(ordered)]
    wanted = single_effects.single_names(starts)
    assert list(dict.fromkeys(s.effects[0].effect for s in wanted)) == list(effects)
    assert len(wanted) >= names
    assert wanted == starts[: len(wanted)]


@pytest.mark.parametrize("near", [True, False])
def test_the_model_as_given_is_looked_about_only_where_the_retune_is_not_far_better(rubbing, monkeypatch, near):
    """Names that are liked there are fitted in their own order: their starts cost more than those about the re-tune."""
    free = rubbing.base.fit.free
    given = fit(rubbing.weighed, free, np.zeros(len(free)), steps=0)
    monkeypatch.setattr(single_effects, "ASTRAY", given.cost / rubbing.base.fit.cost * (1.01 if near else 0.99))
    monkeypatch.setattr(single_effects, "SINGLES", 1)
    monkeypatch.setattr(single_effects, "FAMILIES", 1)
    about = []
    monkeypatch.setattr(single_effects, "look", lambda weighed, fit, *more, **how: (about.append(fit), look(weighed, fit, *more, **how))[1])
    everything = [FRICTION, *BESIDE]
    seen = look(rubbing.weighed, rubbing.base.fit, everything)
    _, wanted = single_effects.single_starts(rubbing.weighed, rubbing.judged, rubbing.base, seen, everything)
    assert [f.cost for f in about] == [given.cost] * near
    assert {s.effects[0] for s in wanted} == {FRICTION, *(BESIDE if near else ())}


def test_results_do_not_depend_on_the_number_of_threads(rubbing, monkeypatch):
    """To the bit, in their order; and the first error comes through."""
    begun = [FRICTION, Candidate("quadratic_damping", "square", (1,)), Candidate("drive_lag", "first_order", (1,))]
    found = []
    for count in (1, 3):
        monkeypatch.setattr(threads, "_count", count)
        seen = look(rubbing.weighed, rubbing.base.fit, begun)
        alone = singles(rubbing.weighed, rubbing.base.fit, seen, begun)
        found.append((seen.fitted[0], [h.fit.x for h in refined(rubbing.weighed, rubbing.judged, alone)]))
    (gram, one), (other, three) = found
    np.testing.assert_array_equal(gram, other)
    for a, b in zip(one, three, strict=True):
        np.testing.assert_array_equal(a, b)
    with pytest.raises(ZeroDivisionError):
        threads.at_once(lambda x: 1 // x, [1, 0, 2])


def test_no_name_stands_beside_its_own_special_case():
    cubic, wide = Candidate("cubic_stiffness", "cubic", (0,)), Candidate("configuration_dependent_stiffness", "well", (0,))
    assert not apart(cubic, wide)
    assert not apart(wide, cubic)
    assert not apart(cubic, Candidate("cubic_stiffness", "mixed", (1,)))
    assert apart(cubic, FRICTION)


def test_at_another_joint_or_where_it_couples_what_the_other_does_not_a_simpler_name_is_no_special_case():
    cubic, coupling = Candidate("cubic_stiffness", "cubic", (0,)), Candidate("lift_swing_coupling", "damping", (0, 1))
    for form, joints, beside in (("well", (1,), (cubic, coupling)), ("well", (0, 1), (coupling,)), ("potential", (0, 1), ())):
        wide = Candidate("configuration_dependent_stiffness", form, joints)
        assert all(apart(c, wide) == apart(wide, c) == (c in beside) for c in (cubic, coupling))
