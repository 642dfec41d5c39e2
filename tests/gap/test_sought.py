"""Fits that short pieces lead, where a free run's cost is rough; and what else keeps a right name from being overlooked."""

from __future__ import annotations

import numpy as np
import pytest
from test_moves import FRICTION, fitted, shaken

from hamr_gap.hypothesis import Start, refine
from hamr_gap.legs import machine_of
from hamr_gap.moves import first_families, first_of_each, look, singles
from hamr_gap.parameters import Candidate, effect_parameters
from hamr_gap.prepare import Prepared, prepare
from hamr_gap.simpler import special_cases
from hamr_gap.sought import sought
from hamr_gap.weighed import Weighed

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
    monkeypatch.setattr("hamr_gap.sought.ROUGH", 0.0)
    starts = [bold(sticking, BRISTLES, share) for share in (1.0, 0.8, 0.6, 0.4)]
    fitted, rough = sought(sticking.weighed, sticking.judged, starts)
    direct, led = fitted[: len(starts)], fitted[len(starts) :]
    assert rough and led
    assert max(h.fit.cost for h in direct) > 2.0 * min(h.fit.cost for h in led)
    assert min(h.fit.cost for h in led) < 1.3 * min(h.fit.cost for h in fitted)
    assert min(h.left for h in fitted) < 1.7 < 0.01 * sticking.base.left
    assert all(h.effects == (BRISTLES,) for h in fitted)


def test_nothing_is_led_beside_what_explains_the_record(sticking, monkeypatch):
    known = refine(sticking.weighed, sticking.judged, bold(sticking, BRISTLES))
    about = (sticking.weighed, sticking.judged, [bold(sticking, FRICTION)], [known])
    missed = sticking.weighed.missed(known.fit.reading).max()
    monkeypatch.setattr(Weighed, "in_pieces", lambda weighed: 1 / 0)
    monkeypatch.setattr("hamr_gap.sought.ROUGH", 1.01 * missed)
    (found,), rough = sought(*about)
    assert found.effects == (FRICTION,) and not rough
    monkeypatch.setattr("hamr_gap.sought.ROUGH", 0.99 * missed)
    assert len(sought(*about, rough=False)[0]) == 1
    with pytest.raises(ZeroDivisionError):
        sought(*about)


def test_where_short_pieces_lead_the_first_nowhere_the_rest_is_not_led(monkeypatch):
    """Damping at one joint or the other: neither explains the friction, and both costs are smooth."""
    rubbing = prepare(machine_of("simple", "fl"), shaken("coulomb_friction.presliding", {"level.0": 4e-3, "distance.0": 0.005}))
    starts = [bold(rubbing, Candidate("quadratic_damping", "square", (joint,))) for joint in (0, 1)]
    led, real = [], Weighed.in_pieces
    monkeypatch.setattr(Weighed, "in_pieces", lambda weighed: (led.append(weighed), real(weighed))[1])
    monkeypatch.setattr("hamr_gap.sought.FIRST", 1)
    fitted, rough = sought(rubbing.weighed, rubbing.judged, starts)
    assert len(fitted) == 2 and not rough and len(led) == 1


def test_of_two_names_alike_each_is_tried_from_the_others_numbers():
    """A lag of some time is nearly a delay of the same."""
    late = prepare(machine_of("simple", "fl"), shaken("drive_lag.first_order", {"time.1": 0.4}))
    delay = fitted(late, Candidate("drive_delay", "pade", (1,)))
    (lag,) = special_cases(late.weighed, late.judged, delay)
    assert lag.names == frozenset({("drive_lag", (1,))})
    assert lag.left < 1.1 < delay.left


def test_a_stop_at_the_end_of_the_travel_is_seen_there():
    """Far beyond what is usual on a leg whose other joint hardly moves."""
    edge = prepare(machine_of("simple", "fl"), shaken("end_stop.upper", {"stiffness.0": 1.0, "limit.0": 0.3}, (9.0, 1.0)))
    usual = edge.weighed.model.scales.coordinate
    assert 3.2 * usual < 0.3
    c = Candidate("end_stop", "upper", (0,))
    begun = singles(edge.weighed, edge.base.fit, look(edge.weighed, edge.base.fit, [c]), [c])
    best = refine(edge.weighed, edge.judged, min(begun, key=lambda start: start.cost))
    assert best.left < 1.3 < 0.01 * edge.base.left
    limit = dict(zip((f.row for f in best.fit.free), best.fit.x, strict=True))["end_stop.upper.limit.0"]
    assert limit * usual == pytest.approx(0.3, rel=0.01)


def test_places_of_one_effect_crowd_no_other_out():
    """Of three effects, one at both joints and at one of them, two are wanted: all that comes before the third."""
    wide, lag = Candidate(FRICTION.effect, FRICTION.form, (0, 1)), Candidate("drive_lag", "first_order", (1,))
    order = (wide, FRICTION, lag, Candidate("quadratic_damping", "square", (1,)))
    found = [Start((c,), (), np.zeros(0), float(cost)) for cost, c in enumerate(order)]
    assert [s.effects[0] for s in first_families(found, 2)] == [wide, FRICTION, lag]
    assert [s.effects[0] for s in first_of_each(found, 2)] == [wide, FRICTION]
