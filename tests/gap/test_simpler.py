"""Moves of the search that take away or put in the place of, on a leg of HAMR-simple with friction in its swing joint."""

from __future__ import annotations

from dataclasses import replace

import pytest
from shaken_leg import FRICTION, fitted, shaken

from hamr_gap.fitting.parameters import Candidate
from hamr_gap.legs import machine_of
from hamr_gap.naming.prepare import prepare
from hamr_gap.naming.simpler import as_narrow, in_its_place, narrowed, special_cases, without


def test_what_is_superfluous_falls_away_and_the_rest_fits_as_well(rubbing):
    wide = fitted(rubbing, Candidate("coulomb_friction", "presliding", (0, 1)), Candidate("drive_lag", "first_order", (1,)))
    found = narrowed(rubbing.weighed, rubbing.judged, wide)
    best = {h.names: h.left for h in found}
    assert best[frozenset({FRICTION.name})] < 1.05 * wide.left
    assert rubbing.base.left > 3.0 * wide.left
    assert without(rubbing.weighed, rubbing.judged, wide, wide.effects[0]).left > 2.0 * wide.left


def test_a_form_found_at_both_joints_is_tried_at_the_one_where_another_does_as_well(rubbing):
    """Or the simplest form of a name would be known at both only, and never be its answer at one."""
    wide, narrow = (fitted(rubbing, replace(FRICTION, form=form, joints=at)) for form, at in (("presliding", (0, 1)), ("lugre", (0,))))
    (found,) = as_narrow(rubbing.weighed, rubbing.judged, [wide, narrow])
    assert found.effects == (FRICTION,)
    assert found.left < 1.05 * narrow.left
    assert as_narrow(rubbing.weighed, rubbing.judged, [wide]) == []  # nothing says that one joint is enough
    assert as_narrow(rubbing.weighed, rubbing.judged, [wide, narrow, found]) == []


def test_a_name_that_holds_a_simpler_one_gives_way_to_it(rubbing):
    h = fitted(rubbing, Candidate("stribeck_friction", "lugre", (0,)))
    simple = special_cases(rubbing.weighed, rubbing.judged, h)
    assert {s.names for s in simple} == {frozenset({FRICTION.name})}
    assert {s.effects[0].form for s in simple} == {"sign", "presliding", "lugre", "asymmetric", "loaded"}
    assert min(s.left for s in simple) < 1.05 * h.left


def test_of_several_effects_each_is_tried_in_its_other_forms(rubbing):
    """A single one has been; two were found beside some one form of the other."""
    lag = Candidate("drive_lag", "first_order", (1,))
    two = special_cases(rubbing.weighed, rubbing.judged, fitted(rubbing, FRICTION, lag))
    assert {h.effects for h in two} >= {(replace(FRICTION, form=form), lag) for form in ("sign", "lugre", "asymmetric")}
    assert special_cases(rubbing.weighed, rubbing.judged, fitted(rubbing, FRICTION)) == []


def test_a_simpler_name_that_stands_at_the_other_joint_already_stands_at_both(rubbing):
    sets = [h.effects for h in special_cases(rubbing.weighed, rubbing.judged, fitted(
        rubbing, replace(FRICTION, form="sign"), Candidate("stribeck_friction", "lugre", (1,))))]  # fmt: skip
    assert sets.count((Candidate("coulomb_friction", "sign", (0, 1)),)) == 1  # its other forms, at the other joint, are no one form at both
    assert all(len({c.effect for c in effects}) == len(effects) for effects in sets)


def test_of_a_name_at_both_joints_a_special_case_may_suffice_at_either(rubbing):
    cases = special_cases(rubbing.weighed, rubbing.judged, fitted(rubbing, Candidate("stribeck_friction", "lugre", (0, 1))))
    found = {h.names: h.left for h in cases}
    where, elsewhere = (frozenset({("stribeck_friction", (j,)), ("coulomb_friction", (1 - j,))}) for j in (0, 1))
    assert found[where] == pytest.approx(found[elsewhere], rel=0.05)  # Stribeck's is at neither


def test_what_is_better_in_its_place_is_looked_at_in_turn():
    """Creep can be taken for a relaxing spring, and that for structural damping."""
    lossy = prepare(machine_of("simple", "fl"), shaken("structural_damping.ladder", {"loss.0": 0.02, "time.0": 3.0}))
    h = fitted(lossy, Candidate("piezo_creep", "logarithmic", (0,)))
    found = in_its_place(lossy.weighed, lossy.judged, h)
    best = min(found, key=lambda s: s.left)
    assert best.names == frozenset({("structural_damping", (0,))})
    assert best.left < min(s.left for s in found if s.names == frozenset({("viscoelasticity", (0,))})) < h.left


def test_a_coupled_potential_gives_way_to_the_one_spring_that_it_is():
    bent = prepare(machine_of("simple", "fl"), shaken("cubic_stiffness.cubic", {"cubic.1": 2.0}))
    h = fitted(bent, Candidate("configuration_dependent_stiffness", "potential", (0, 1)))
    best = min(special_cases(bent.weighed, bent.judged, h), key=lambda s: (s.left > 1.02 * h.left, s.parameters))
    assert best.names == frozenset({("cubic_stiffness", (1,))})
    assert best.left < 1.02 * h.left < 0.2 * bent.base.left


def test_a_spring_across_both_angles_is_tried_at_each_joint_by_itself(rubbing, monkeypatch):
    """From where it is: the same centre, width and stiffness."""
    monkeypatch.setattr("hamr_gap.naming.simpler.refined", lambda weighed, judged, wanted: wanted)
    oblique = Candidate("configuration_dependent_stiffness", "oblique", (0, 1))
    h = fitted(rubbing, oblique)
    own = {s.effects[0]: s for s in special_cases(rubbing.weighed, rubbing.judged, h) if s.effects[0].effect == oblique.effect}
    for joint in (0, 1):
        valley = own[Candidate(oblique.effect, "valley", (joint,))]
        begun = {f.row: x for f, x in zip(valley.free, valley.x, strict=True)}
        known = {f.row: x for f, x in zip(h.fit.free, h.fit.x, strict=True)}
        for name in ("stiffness", "centre", "width"):
            assert begun[f"{oblique.effect}.valley.{name}.{joint}"] == known[f"{oblique.effect}.oblique.{name}.0"]


def test_an_inertia_that_seems_to_vary_gives_way_to_the_constant_coupling_that_it_is():
    """The re-tune takes most of the coupling up by making all else lighter, so that only its velocity forces seem to be missing."""
    coupled = prepare(machine_of("simple", "fl"), shaken("lift_swing_coupling.inertia", {"inertia.0": -0.6}))
    h = fitted(coupled, Candidate("configuration_dependent_inertia", "polynomial", (0, 1)))
    best = min(special_cases(coupled.weighed, coupled.judged, h), key=lambda s: s.left)
    assert (best.effects[0].effect, best.effects[0].form) == ("lift_swing_coupling", "inertia")
    assert best.left - 1.0 < 0.02 * (coupled.base.left - 1.0)
