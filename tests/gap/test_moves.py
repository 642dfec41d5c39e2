"""The search's moves and what a fit believes, on one leg of HAMR-simple with friction in its swing joint and on HAMR-full."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter

from hamr_dynamics import machine_kernel
from hamr_dynamics.effects.law import Scales
from hamr_dynamics.effects.library import find
from hamr_gap.data.readings import fresh
from hamr_gap.data.record import Record
from hamr_gap.fitting import threads
from hamr_gap.fitting.descent import FIRST
from hamr_gap.fitting.fit import fit
from hamr_gap.fitting.model import Model
from hamr_gap.fitting.parameters import Candidate, effect_parameters
from hamr_gap.fitting.sensors import Sensors
from hamr_gap.flagship_find import recorded
from hamr_gap.judging.colour import correlation_time
from hamr_gap.legs import machine_of
from hamr_gap.naming import single_effects
from hamr_gap.naming.hypothesis import Start, refine, refined
from hamr_gap.naming.moves import ALONE, apart, at_both, look, pairs_of, promising, singles
from hamr_gap.naming.prepare import Prepared, prepare
from hamr_gap.naming.screen import Column, Screen
from hamr_gap.naming.simpler import as_narrow, in_its_place, narrowed, special_cases, without

STEP, SECONDS = 0.25, 5.0  # ms, s
FRICTION = Candidate("coulomb_friction", "presliding", (0,))


@pytest.fixture(scope="module")
def rubbing() -> Prepared:
    """A leg with friction in its swing joint."""
    return prepare(machine_of("simple", "fl"), shaken("coulomb_friction.presliding", {"level.0": 4e-3, "distance.0": 0.005}))


def shaken(law: str, rows: dict[str, float], volts: tuple[float, float] = (9.0, 9.0)) -> Record:
    """A leg with some rows of a law on, driven by noise to 40 Hz: 40 waves of some amplitude, V, in each joint."""
    leg = machine_of("simple", "fl")
    n = int(SECONDS * 1e3 / STEP)
    random, time = np.random.default_rng(2), np.arange(n) * STEP * 1e-3
    waves = [(random.uniform(3.0, 40.0), random.uniform(0.0, 2 * np.pi, 2)) for _ in range(40)]
    drives = np.array(volts) * sum(np.sin(2 * np.pi * hz * time[:, None] + phase) for hz, phase in waves)
    row = leg.neutral(Scales(0.06, 0.1, 0.07, 60.0, 12e3))
    for name, x in rows.items():
        row[leg.parameter_rows.index(f"{law}.{name}")] = x
    truth = machine_kernel.simulate(leg, np.repeat(drives, 5, axis=0), row[None], step=STEP / 5, substeps=1)[0][::5]
    readings = truth + 1e-3 * np.ptp(truth, axis=0) * random.standard_normal(truth.shape)
    return Record(drives, readings, STEP, leg.channels)


def fitted(prepared: Prepared, *effects: Candidate):
    free = (*prepared.base.fit.free, *effect_parameters(effects, prepared.weighed.model.scales))
    x = np.array([*prepared.base.fit.x, *(f.center or 1e-3 * f.sd for f in free[len(prepared.base.fit.x) :])])
    return refine(prepared.weighed, prepared.judged, Start(effects, free, x, np.inf))


@pytest.mark.parametrize("level", [2e-4, 2e-3])
def test_the_step_is_small_beside_what_is_missing(level):
    """Weak friction leaves half of the noise beyond it: an error of the step of a fifth of the noise would pass for some of that."""
    weak = prepare(machine_of("simple", "fl"), shaken("coulomb_friction.presliding", {"level.0": level, "distance.0": 0.005}, (25.0, 25.0)))
    model, fit = weak.weighed.model, weak.base.fit
    moved = np.subtract(*(replace(model, substeps=n * model.substeps).runs(fit.free, fit.x)[0] for n in (1, 2)))
    columns = weak.weighed.sensor_columns(fit.run)
    moved = weak.weighed.vector(moved)
    moved -= columns @ np.linalg.lstsq(columns, moved, rcond=None)[0]
    assert np.mean(moved**2) < 0.015 * (weak.base.left - 1.0)


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
    assert (Candidate("coulomb_friction", "sign", (0, 1)),) in sets
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


def test_a_threshold_is_where_the_line_through_the_first_responses_meets_zero():
    """Of sizes of which the first two do nothing; one without a threshold does as much as it is large, and a dip counts as level."""
    (limit,), (square,) = (find(*name).sizes for name in (("drive_saturation", "hard"), ("quadratic_damping", "square")))
    sizes, rms = (0.4, 0.45, 0.5, 0.56), np.array([0.0, 0.0, 1.0, 7.0, 3.0])
    columns = [*(Column("limit", limit, size, ()) for size in sizes), Column("square", square, 0.2, ())]
    seen = Screen(columns, 0, {}, (np.diag(rms**2), None, 0.0), np.zeros(5))
    assert [seen.size_of(2, share) for share in (0.0, 0.5, 1.0, 4.0)] == pytest.approx([0.49, 0.495, 0.5, 0.53])
    assert seen.size_of(3, 1 / 7) == pytest.approx(0.5)
    assert seen.size_of(4, 0.5) == 0.1
    dipping = Screen(columns, 0, {}, (np.diag(np.square([3.0, 5.0, 4.0, 6.0, 3.0])), None, 0.0), np.zeros(5))
    assert dipping.size_of(2, 0.9) == pytest.approx(0.43)


BESIDE = (Candidate("quadratic_damping", "square", (1,)), Candidate("drive_lag", "first_order", (1,)))


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
    pairs = pairs_of(rubbing.weighed, rubbing.judged, rubbing.base.fit, seen, everything, alone[1], rough=False)
    assert {frozenset(c.name for c in h.effects) for h in pairs} >= {frozenset({FRICTION.name, c.name}) for c in BESIDE}


def test_starts_far_worse_than_the_best_are_not_fitted():
    starts = [Start((c,), (), np.zeros(0), cost) for c, cost in ((FRICTION, 1.0), (BESIDE[0], 0.99 * ALONE), (BESIDE[1], 1.01 * ALONE))]
    assert promising(starts, ALONE) == starts[:2]


@pytest.mark.parametrize("near", [True, False])
def test_the_model_as_given_is_looked_about_only_where_the_retune_is_not_far_better(rubbing, monkeypatch, near):
    """Names that are liked there are fitted in their own order: their starts cost more than those about the re-tune."""
    free = rubbing.base.fit.free
    given = fit(rubbing.weighed, free, np.zeros(len(free)), steps=0)
    monkeypatch.setattr(single_effects, "ASTRAY", given.cost / rubbing.base.fit.cost * (1.01 if near else 0.99))
    monkeypatch.setattr(single_effects, "SINGLES", 1)
    about = []
    monkeypatch.setattr(single_effects, "look", lambda weighed, fit, *more, **how: (about.append(fit), look(weighed, fit, *more, **how))[1])
    everything = [FRICTION, *BESIDE]
    seen = look(rubbing.weighed, rubbing.base.fit, everything)
    _, wanted = single_effects.single_starts(rubbing.weighed, rubbing.judged, rubbing.base, seen, everything)
    assert [f.cost for f in about] == [given.cost] * near
    assert {s.effects[0] for s in wanted} == {FRICTION, *(BESIDE if near else ())}


def test_responses_that_diverge_are_no_columns(rubbing, monkeypatch):
    """Neither of sizes that were tried smaller in vain, nor of limits that keep theirs."""
    real = Model.run_rows
    monkeypatch.setattr(Model, "run_rows", lambda *given: (run := real(*given)) * np.where(len(run) > 1, 1e30, 1.0))
    seen = look(rubbing.weighed, rubbing.base.fit, [FRICTION, Candidate("drive_saturation", "hard", (1,))])
    own = np.diag(seen.fitted[0])[seen.fixed :]
    assert len(own) > 1
    np.testing.assert_array_equal(own, 0.0)


def test_responses_of_about_the_size_wanted_serve_as_they_are(rubbing, monkeypatch):
    """What is far from it is simulated again, at another size; limits that are screened one by one keep theirs."""
    simulated = []
    real = Model.run_rows
    monkeypatch.setattr(Model, "run_rows", lambda model, rows, *more: (simulated.append(rows), real(model, rows, *more))[1])
    clipped = Candidate("drive_saturation", "hard", (1,))
    seen = look(rubbing.weighed, rubbing.base.fit, [FRICTION, *BESIDE, clipped])
    rows, index = np.concatenate(simulated), rubbing.weighed.model.machine.parameter_rows.index
    resized = [c for c in seen.columns if c.size != c.parameter.typical and not c.parameter.screen]
    assert 0 < len(resized) < len([c for c in seen.columns if not c.parameter.screen])
    for row in {c.row for c in seen.columns}:
        own = [c for c in seen.columns if c.row == row]
        assert np.count_nonzero(rows[:, index(row)]) == len(own) + len([c for c in own if c in resized])


@pytest.mark.filterwarnings("error")
def test_laws_that_move_far_too_much_are_seen_at_smaller_sizes(rubbing, monkeypatch):
    """Without a warning, where the square of what they move is beyond single precision."""
    real = Model.run_rows
    monkeypatch.setattr(Model, "run_rows", lambda *given: 1e22 * real(*given))
    seen = look(rubbing.weighed, rubbing.base.fit, [FRICTION, Candidate("quadratic_damping", "square", (1,))])
    assert [c.size for c in seen.columns] == pytest.approx([1e-3 * c.parameter.typical for c in seen.columns])


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


def test_a_shift_of_the_clocks_in_the_model_is_that_of_its_sensors(rubbing):
    late = 0.3  # ms, no whole number of steps
    moved = rubbing.weighed.on_time(rubbing.weighed.model.delay + late)
    free, x = rubbing.base.fit.free, rubbing.base.fit.x
    step = rubbing.weighed.model.reading_step
    before = Sensors(np.zeros(4), np.zeros(4), late).read(rubbing.weighed.model.runs(free, x)[0], step)
    rest = late - (moved.model.delay - rubbing.weighed.model.delay)
    after = Sensors(np.zeros(4), np.zeros(4), rest).read(moved.model.runs(free, x)[0], step)
    assert np.abs(after - before)[5:-5].max() < 0.1 * rubbing.noise.min()


def test_derivatives_that_promise_in_vain_are_taken_again_more_coarsely(rubbing, monkeypatch):
    """Dry friction that changes its sign at once looks rough from near by: fits from there end in 0.7 of the cost.

    Over many starts, as each end hangs on the last bit of its start.
    """
    effects = (Candidate("coulomb_friction", "sign", (0,)),)
    free = (*rubbing.base.fit.free, *effect_parameters(effects, rubbing.weighed.model.scales))
    moving = rubbing.weighed.chosen.copy()
    moving[:150] = False  # let go from rest it slides one way only
    weighed = replace(rubbing.weighed, chosen=moving)
    starts = [np.array([*rubbing.base.fit.x, level, 1e-3]) for level in np.geomspace(0.03, 0.1, 16)]
    coarse = [fit(weighed, free, x).cost for x in starts]
    monkeypatch.setattr("hamr_gap.fitting.descent.FORESEEN", np.inf)
    fine = [fit(weighed, free, x).cost for x in starts]
    assert sum(coarse) < 0.8 * sum(fine)


def test_steps_beyond_newtons_lead_on_along_what_sticks_and_slips(monkeypatch):
    """Of many starts three times as many find the best there is."""
    stuck = prepare(machine_of("simple", "fl"), shaken("coulomb_friction.presliding", {"level.0": 0.01, "distance.0": 0.004}))
    free = (*stuck.base.fit.free, *effect_parameters((FRICTION,), stuck.weighed.model.scales))
    added, shares = free[len(stuck.base.fit.x) :], np.geomspace(0.05, 2.7, 32)
    starts = [np.array([*stuck.base.fit.x, *(f.center or share * f.sd / 30 for f in added)]) for share in shares]
    beyond = np.array([fit(stuck.weighed, free, x).cost for x in starts])
    monkeypatch.setattr("hamr_gap.fitting.descent.FIRST", np.minimum(FIRST, 1.0))
    capped = np.array([fit(stuck.weighed, free, x).cost for x in starts])
    found = 1.05 * min(beyond.min(), capped.min())
    assert np.sum(beyond < found) > 1.5 * np.sum(capped < found)


def test_no_sensor_changes_its_scale_to_mend_a_wrong_model():
    """Three seconds of HAMR-full seen by HAMR-simple: with priors against the noise alone an encoder's scale doubled."""
    prepared = prepare(machine_of("simple", "fl"), recorded("fl", seconds=3.0, noise=1e-3, seed=3))
    assert prepared.base.left > 100.0  # in units of the noise: a model error
    assert np.abs(prepared.base.fit.sensors.gain).max() < 0.05  # five standard deviations


@given(st.floats(0.0, 0.9))
def test_correlated_readings_count_less(share):
    """Of a first-order process, (1 + a) / (1 - a) readings say what one independent reading would."""
    x = lfilter([1.0], [1.0, -share], np.random.default_rng(0).standard_normal((40_000, 2)), axis=0)
    assert correlation_time(x) == pytest.approx((1 + share) / (1 - share), rel=0.15)


def test_what_was_sent_again_is_left_out():
    rng = np.random.default_rng(0)
    readings, drives = rng.normal(size=(1000, 2)), np.zeros((1000, 2))
    again = np.flatnonzero(rng.random(999) < 0.05) + 1
    for k in again:
        readings[k] = readings[k - 1]
    left = fresh(Record(drives, readings, STEP, ("a", "b"))).readings
    assert np.flatnonzero(np.isnan(left).all(1)).tolist() == again.tolist()
    coarse = Record(drives, np.round(rng.normal(size=(1000, 2))), STEP, ("a", "b"))
    assert np.isfinite(fresh(coarse).readings).all()  # says the same twice by right


def test_a_slow_sensor_says_something_new_when_it_does():
    readings = np.repeat(np.sin(0.1 * np.arange(200)), 5)[:, None]
    left = fresh(Record(np.zeros((1000, 1)), readings, STEP, ("a",))).readings
    assert np.array_equal(np.flatnonzero(np.isfinite(left[:, 0])), np.arange(0, 1000, 5))


@pytest.mark.parametrize("seen", [
    np.maximum(np.sin(0.002 * np.arange(5000)), 0.3),  # rests on a stop
    np.interp(1.06 * np.arange(4700), np.arange(5000), np.round(np.sin(0.006 * np.arange(5000)), 3)),  # coarse, and resampled
])  # fmt: skip
def test_what_stands_still_is_not_sent_again(seen):
    assert np.isfinite(fresh(Record(np.zeros((len(seen), 1)), seen[:, None], STEP, ("a",))).readings).all()


@given(st.integers(1, 4), st.floats(0.0, 0.2))
def test_a_held_command_is_late_by_half_of_what_it_is_held_for(substeps, hold):
    time = STEP * np.arange(400)
    record = Record(np.sin(0.05 * time)[:, None], np.zeros((400, 1)), STEP, ("q",), hold=hold)
    middle = (np.arange(400 * substeps) + 0.5) * STEP / substeps
    inside = slice(20 * substeps, -20 * substeps)
    np.testing.assert_allclose(record.fine(substeps)[inside, 0], np.sin(0.05 * (middle - 0.5 * hold))[inside], atol=1e-6)


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
