"""Fits that short pieces lead, where a free run's cost is rough; and what else keeps a right name from being overlooked."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from oscillator import MACHINE, STEP, oscillator
from scipy.signal import lfilter
from shaken_leg import FRICTION, fitted, shaken
from threadpoolctl import threadpool_info, threadpool_limits

from hamr_dynamics.effects.library import library
from hamr_dynamics.machine import with_motion
from hamr_gap.fitting.descent import descend
from hamr_gap.fitting.fit import ROUGH, fit
from hamr_gap.fitting.parameters import Candidate, effect_parameters
from hamr_gap.fitting.race import FEW, raced
from hamr_gap.fitting.weighed import Weighed
from hamr_gap.judging import analyse
from hamr_gap.legs import machine_of
from hamr_gap.naming import search, tried
from hamr_gap.naming.candidates import candidates
from hamr_gap.naming.hypothesis import Start, refine, refined
from hamr_gap.naming.moves import first_families, first_of_each, look, singles
from hamr_gap.naming.prepare import Prepared, prepare
from hamr_gap.naming.simpler import special_cases
from hamr_gap.naming.sought import sought

BRISTLES = Candidate("coulomb_friction", "lugre", (0, 1))


@pytest.fixture(scope="module")
def sticking() -> Prepared:
    """A leg with friction of a third of its drive: it sticks and lets go."""
    rows = {"level.0": 2e-2, "distance.0": 1e-3, "level.1": 1e-2, "distance.1": 1e-3}
    return prepare(machine_of("simple", "fl"), shaken("coulomb_friction.lugre", rows))


def bold(prepared: Prepared, c: Candidate, share: float = 1.0) -> Start:
    """From sizes as large as their priors, or a share of that."""
    free = (*prepared.base.fit.free, *effect_parameters((c,), prepared.weighed.model.scales))
    x = np.array([*prepared.base.fit.x, *(f.center or share * f.sd for f in free[len(prepared.base.fit.x) :])])
    return Start((c,), free, x, np.inf)


def test_short_pieces_lead_where_free_runs_rest_elsewhere(sticking, monkeypatch):
    """From near and far: where fits of free runs rest hangs on rounding, so that some of them do is all that can be said."""
    monkeypatch.setattr("hamr_gap.fitting.fit.ROUGH", 0.0)
    starts = [bold(sticking, BRISTLES, share) for share in (1.0, 0.8, 0.6, 0.4)]
    fitted = sought(sticking.weighed, sticking.judged, starts)
    direct, led = fitted[: len(starts)], fitted[len(starts) :]
    assert led
    assert max(h.fit.cost for h in direct) > 2.0 * min(h.fit.cost for h in led)
    assert min(h.fit.cost for h in led) < 1.3 * min(h.fit.cost for h in fitted)
    assert min(h.left for h in fitted) < 1.7 < 0.01 * sticking.base.left
    assert all(h.effects == (BRISTLES,) for h in fitted)


def test_nothing_is_led_beside_what_explains_the_record(sticking, monkeypatch):
    known = refine(sticking.weighed, sticking.judged, bold(sticking, BRISTLES))
    about = (sticking.weighed, sticking.judged, [bold(sticking, FRICTION)], [known])
    missed = sticking.weighed.missed(known.fit.reading).max()
    monkeypatch.setattr(Weighed, "in_pieces", property(lambda weighed: 1 / 0))
    monkeypatch.setattr("hamr_gap.fitting.fit.ROUGH", 1.01 * missed)
    (found,) = sought(*about)
    assert found.effects == (FRICTION,)
    monkeypatch.setattr("hamr_gap.fitting.fit.ROUGH", 0.99 * missed)
    assert len(sought(*about, rough=False)) == 1
    with pytest.raises(ZeroDivisionError):
        sought(*about)


def test_a_set_is_led_however_little_free_runs_like_it(sticking, monkeypatch):
    """Bristles behind half a dozen wrong names."""
    names = ("quadratic_damping", "square"), ("cubic_stiffness", "cubic")
    wrong = [Candidate(*name, joints) for name in names for joints in ((0,), (1,), (0, 1))]
    starts = [*(bold(sticking, c, 0.1) for c in wrong), bold(sticking, BRISTLES, 0.6)]

    def misled(*about) -> list:
        *found, bristles = refined(*about)
        return [*found, replace(bristles, fit=replace(bristles.fit, cost=2.0 * max(h.fit.cost for h in found)))]

    monkeypatch.setattr("hamr_gap.fitting.fit.ROUGH", 0.0)
    monkeypatch.setattr("hamr_gap.naming.sought.refined", misled)
    led = sought(sticking.weighed, sticking.judged, starts)[len(starts) :]
    best = min(led, key=lambda h: h.left)
    assert best.effects == (BRISTLES,)
    assert best.left < 1.7


def test_of_sets_those_that_come_near_the_best_are_fitted_to_the_end(rubbing, monkeypatch):
    """The others are left where steps gain little: forms of friction leave a hundredth of what damping does."""
    wanted = (FRICTION, replace(FRICTION, form="lugre"), Candidate("quadratic_damping", "square", (0,)))
    starts = [bold(rubbing, c, 0.1) for c in wanted]
    told = []

    def heard(weighed, at, **how):
        told.append((at.free, how))
        return descend(weighed, at, **how)

    monkeypatch.setattr("hamr_gap.fitting.race.descend", heard)
    found = raced(rubbing.weighed, ((start.free, start.x) for start in starts))
    assert [free for free, how in told if not how] == [start.free for start in starts[:2]]
    ends = [fit(rubbing.weighed, start.free, start.x).cost for start in starts]
    assert [f.cost for f in found[:2]] == pytest.approx(ends[:2], rel=1e-3)
    assert min(ends[2], found[2].cost) > 100.0 * max(ends[:2])
    assert [f.free for f in found] == [start.free for start in starts]


@pytest.mark.parametrize(("few", "explained", "fits"), [(FEW, True, 1), (FEW, False, 2), (40, False, 1)])
@pytest.mark.parametrize("known", [True, False])
def test_what_is_far_from_a_set_that_explains_the_record_is_left(rubbing, monkeypatch, few, explained, fits, known):
    """After a few steps; where none in the race or known beforehand explains it, all go on that have not ended by then."""
    wrong = bold(rubbing, Candidate("configuration_dependent_damping", "polynomial", (0,)), 0.1)
    right = bold(rubbing, FRICTION, 0.1)
    others = [refine(rubbing.weighed, rubbing.judged, right).fit] if known else []
    steps = []

    def counted(weighed, at, **how):
        found = descend(weighed, at, **how)
        steps.extend([found.steps] * (at.free == wrong.free))
        return found

    monkeypatch.setattr("hamr_gap.fitting.race.descend", counted)
    monkeypatch.setattr("hamr_gap.fitting.race.FEW", few)
    monkeypatch.setattr("hamr_gap.fitting.fit.ROUGH", ROUGH if explained else 0.0)
    raced(rubbing.weighed, [(start.free, start.x) for start in (wrong, *[right] * (not known))], others)
    assert len(steps) == fits + (known and not explained)  # to the end, as it is alone
    assert FEW <= steps[0] <= few


def test_of_two_names_alike_each_is_tried_from_the_others_numbers(monkeypatch):
    """A lag of some time is nearly a delay of the same; what is late in the drive may be late in the sensor."""
    late = prepare(machine_of("simple", "fl"), shaken("drive_lag.first_order", {"time.1": 0.4}))
    delay = fitted(late, Candidate("drive_delay", "pade", (1,)))
    lag, latency = special_cases(late.weighed, late.judged, delay)
    assert (lag.names, latency.names) == (frozenset({("drive_lag", (1,))}), frozenset({("sensor_latency", (1,))}))
    assert lag.left < 1.1 < delay.left
    monkeypatch.setattr("hamr_gap.naming.simpler.refined", lambda weighed, judged, wanted: wanted)
    tried = (delay.fit, *special_cases(late.weighed, late.judged, delay))
    known, *begun = ({f.row: x for f, x in zip(at.free, at.x, strict=True)} for at in tried)
    rows = "drive_lag.first_order.time.1", "sensor_latency.pade.delay.1"
    assert [at[row] for at, row in zip(begun, rows, strict=True)] == [known["drive_delay.pade.delay.1"]] * 2


def test_every_name_that_another_is_taken_for_is_tried_in_its_place_whatever_it_acts_on(sticking, monkeypatch):
    monkeypatch.setattr("hamr_gap.naming.simpler.refined", lambda weighed, judged, wanted: [start.effects[0].name for start in wanted])
    base, possible = sticking.base, candidates(sticking.weighed.model.machine, sticking.weighed.model.record)
    for c in possible:
        free = effect_parameters((c,), sticking.weighed.model.scales)
        found = replace(base.fit, free=(*base.fit.free, *free), x=np.append(base.fit.x, [f.center for f in free]))
        own = library()[c.effect]
        alike = {(name, c.joints) for name in (*own.contains, *own.mimics, *own.same_as)}
        alike &= {some.name for some in possible if some.law.acts != "pair" or c.law.acts == "pair"}  # no law of one joint couples two
        assert alike <= set(special_cases(sticking.weighed, sticking.judged, replace(base, effects=(c,), fit=found)))


@pytest.mark.parametrize(("channel", "names"), [("", {"drive_delay", "sensor_lag"}), ("_rate", {"drive_delay"})])
def test_what_is_the_same_is_tried_where_a_sensor_reads_it(channel, names):
    """A linear joint behind a lag moves as one that is read through it; a gyroscope's own lag is no name."""
    _, through = oscillator(lambda q, v: 0.0)
    share = 1.0 - np.exp(-STEP / 8e-3)
    lagged = lfilter([share], [1.0, share - 1.0], np.gradient(through.readings[:, 0], STEP) if channel else through.readings[:, 0])
    machine = with_motion(MACHINE)
    late = prepare(machine, replace(through, readings=lagged[:, None], channels=(f"{MACHINE.channels[0]}{channel}",)))
    drive = fitted(late, Candidate("drive_lag", "first_order", (0,)))
    tried = {(c.effect, c.form): h.left for h in special_cases(late.weighed, late.judged, drive) for c in h.effects}
    assert {name for name, _ in tried} == names
    assert late.base.left > 3.0 * drive.left
    if not channel:
        assert tried["sensor_lag", "first_order"] == pytest.approx(drive.left, rel=0.01)


def test_a_stop_at_the_end_of_the_travel_is_seen_there():
    """Far beyond what is usual on a leg whose other joint hardly moves. Nearer limits leave more than the re-tune, and look like none."""
    edge = prepare(machine_of("simple", "fl"), shaken("end_stop.upper", {"stiffness.0": 1.0, "limit.0": 0.32}, (9.0, 1.0)))
    usual = edge.weighed.model.scales.coordinate
    assert 3.5 * usual < 0.32
    c = Candidate("end_stop", "upper", (0,))
    begun = min(singles(edge.weighed, edge.base.fit, look(edge.weighed, edge.base.fit, [c]), [c]), key=lambda start: start.cost)
    assert begun.cost < 0.2 * edge.base.fit.cost
    best = refine(edge.weighed, edge.judged, begun)
    assert best.left < 0.02 * edge.base.left
    limit = dict(zip((f.row for f in best.fit.free), best.fit.x, strict=True))["end_stop.upper.limit.0"]
    assert limit * usual == pytest.approx(0.32, rel=0.01)


def test_places_of_one_effect_crowd_no_other_out():
    """Of three effects, one at both joints and at one of them, two are wanted: all that comes before the third."""
    wide, lag = Candidate(FRICTION.effect, FRICTION.form, (0, 1)), Candidate("drive_lag", "first_order", (1,))
    order = (wide, FRICTION, lag, Candidate("quadratic_damping", "square", (1,)))
    found = [Start((c,), (), np.zeros(0), float(cost)) for cost, c in enumerate(order)]
    assert [s.effects[0] for s in first_families(found, 2)] == [wide, FRICTION, lag]
    assert [s.effects[0] for s in first_of_each(found, 2)] == [wide, FRICTION]


def test_sets_are_led_only_on_a_record_whose_single_effects_were(sticking, monkeypatch):
    """What `search` hands on to its moves."""
    wanted = [FRICTION, BRISTLES, Candidate("drive_lag", "first_order", (1,))]
    told = []
    monkeypatch.setattr(search, "candidates", lambda *_: wanted)
    monkeypatch.setattr(search, "in_other_shapes", lambda *_: [])
    monkeypatch.setattr(search, "without", lambda weighed, judged, h, effect: sticking.base)
    for module, limit in ((search, "CLEAR"), (search, "LONELY"), (tried, "FAINT"), (tried, "ENOUGH")):
        monkeypatch.setattr(module, limit, 0.0)
    monkeypatch.setattr(search, "pairs_of", lambda weighed, judged, state, *_: (told.append(state.rough), 1 / 0))  # no further
    for more in (0, 1):
        monkeypatch.setattr(search, "sought", lambda *about, more=more: (found := sought(*about, rough=False)) + found[:1] * more)
        with pytest.raises(ZeroDivisionError):
            search.search(sticking.weighed, sticking.judged, sticking.base, timed=True)
    assert told == [False, True]


@pytest.mark.parametrize(("name", "form", "explains"), [("coulomb_friction", "sign", True), ("quadratic_damping", "square", False)])
def test_simpler_names_are_looked_for_of_what_explains_half_of_the_gap(rubbing, monkeypatch, name, form, explains):
    """Friction that changes at once leaves a fifth of what slides before it sticks."""
    looked = []
    monkeypatch.setattr(search, "candidates", lambda *_: [Candidate(name, form, (0,))])
    monkeypatch.setattr(search, "LARGEST", 1)
    for move in ("twins", "in_its_place", "narrowed", "as_narrow"):
        monkeypatch.setattr(search, move, lambda *_, move=move: looked.append(move) or [])
    found = search.search(rubbing.weighed, rubbing.judged, rubbing.base, timed=True)
    assert (0.1 < found.best.left / found.base.left < 0.3) == explains
    assert looked == ["twins", "in_its_place", "narrowed", "as_narrow"] * explains


@pytest.mark.parametrize(("form", "alone"), [("presliding", True), ("sign", False)])
def test_pairs_without_an_effect_that_leaves_little_are_not_fitted(rubbing, monkeypatch, form, alone):
    """Others stand beside it."""
    told = []
    monkeypatch.setattr(search, "candidates", lambda *_: [Candidate("coulomb_friction", form, (0,))])
    for module, limit in ((search, "CLEAR"), (tried, "FAINT"), (tried, "ENOUGH")):
        monkeypatch.setattr(module, limit, 0.0)
    monkeypatch.setattr(search, "LARGEST", 2)
    monkeypatch.setattr(search, "noise_floor", lambda *_: 0.5)  # so that both leave something
    for move in ("pairs_of", "beside"):
        monkeypatch.setattr(search, move, lambda *_, move=move: told.append(move) or [])
    for move in ("exchange", "twins", "_simplify"):
        monkeypatch.setattr(search, move, lambda *_: None)
    found = search.search(rubbing.weighed, rubbing.judged, rubbing.base, timed=True)
    assert (found.best.left < 0.1 * found.base.left) == alone
    assert told == ["pairs_of"] * (not alone) + ["beside"]


def test_an_analysis_keeps_linear_algebra_to_one_thread(monkeypatch):
    """Which it may share with others: afterwards they have theirs again."""

    def threads() -> set[int]:
        return {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}

    seen = []
    monkeypatch.setattr(analyse, "searched", lambda *_: (seen.append(threads()), 1 / 0))
    with threadpool_limits(2):
        with pytest.raises(ZeroDivisionError):
            analyse.analyse(None, None)
        assert (seen, threads()) == ([{1}], {2})
