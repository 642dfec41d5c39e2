"""The rules of the search on the ground, on hypotheses made here: what is fitted for good, what is taken up again, what is unknown."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hamr_gap.fitting.parameters import Free
from hamr_gap.judging.interval import NORMAL_95
from hamr_gap.walking import again, analyse, candidates, looks, screen, search
from hamr_gap.walking.fit import Fit
from hamr_gap.walking.found import _intervals
from hamr_gap.walking.left import Judged
from hamr_gap.walking.segments import CHANGES
from hamr_gap.walking.setting import Candidate, Setting
from hamr_gap.walking.state import Search

FLOOR, LEAST = 0.86, 0.25
FRICTION, SLOPE, TETHER, LAG = (
    Candidate(*names) for names in (("ground_friction", "factor", "all"), ("gravity_tilt", "slope", "chassis"),
                                    ("tether_force", "constant", "chassis"), ("drive_lag", "first_order", "all"))
)  # fmt: skip


class Segments(list):
    """As many segments as there are numbers in it."""

    def __init__(self, count):
        super().__init__(range(count))

    def some(self, which):
        return Segments(len(which))


def left(share: float, *effects: Candidate) -> Judged:
    fitted = SimpleNamespace(model=None, free=(), x=None, change=None)
    return Judged(effects, fitted, share, share * (1.0 + 0.01 * np.sin(np.arange(24.0))), np.full(7, share))


def searched(base: float, *tried: Judged) -> Search:
    judged = SimpleNamespace(observed=SimpleNamespace(readings=100))
    parts = {"fit": None, "select": type("Judged", (SimpleNamespace,), {"__len__": lambda _: 64})(**vars(judged))}
    prepared = SimpleNamespace(
        base=left(base), floor=FLOOR, least=LEAST, numerical=0.1, coarse=False, gap=True, parts=parts, raw=left(2.0 * base)
    )
    return Search(prepared, list(tried))


@pytest.mark.parametrize(("others", "taken_up"), [(1.4, True), (1.6, False)])
def test_a_rival_is_measured_by_what_the_best_left_before_it_was_taken_up(monkeypatch, others, taken_up):
    """The best may leave half as much afterwards, and so may the rival."""
    state, done = searched(9.0, left(2.0, SLOPE), left(2.0 * others, TETHER)), []
    monkeypatch.setattr(again, "_from_given", lambda state, found: found)
    monkeypatch.setattr(again, "_settled", lambda state, *begun: done.append(begun) or left(1.0, SLOPE))
    again.polish(state)
    assert len(done) == 1 + taken_up


@pytest.mark.parametrize(("best", "taken_up", "paired"), [(9.0 - 2.0 * LEAST, 3, 1), (9.0 - 0.5 * LEAST, 1, 0)])
def test_the_best_is_taken_up_again_though_it_gains_little_at_first(monkeypatch, best, taken_up, paired):
    """Its start may be all that is wrong with it; what else there is, and pairs, only where a name gains what counts as a gap."""
    tried = left(best, SLOPE), left(9.0, TETHER), left(9.0, LAG), left(9.0, FRICTION)
    state, done = searched(9.0), {"polished": 0, "paired": 0}
    state.prepared.base.fit.free = ()
    monkeypatch.setattr(search, "prepare", lambda *_: state.prepared)
    monkeypatch.setattr(looks, "screen", lambda _: SimpleNamespace(singles=lambda: []))
    monkeypatch.setattr(looks, "alone", lambda *_: [])
    monkeypatch.setattr(looks, "outside", lambda _: tried)
    monkeypatch.setattr(Search, "judged", lambda _, found: found)
    monkeypatch.setattr(again, "_from_given", lambda _, found: found)
    monkeypatch.setattr(again, "settle", lambda _: None)
    monkeypatch.setattr(again, "shake", lambda _: None)

    def settled(_, found, anew):
        done["polished"] += 1
        return next(h for h in tried if h.fit is found)

    def pairs(*_):
        done["paired"] += 1
        return []

    monkeypatch.setattr(again, "_settled", settled)
    monkeypatch.setattr(looks, "pairs", pairs)
    state.prepared.from_ = lambda _: state.prepared
    search.search("simple", None)
    assert done == {"polished": taken_up, "paired": paired}


@pytest.mark.parametrize(("fine", "adopted"), [(1.0, True), (2.5, False)])
@pytest.mark.parametrize("tried", [(left(2.0, SLOPE), left(2.9, LAG), left(3.5, TETHER)), ()])
def test_finer_steps_are_kept_where_they_leave_less(monkeypatch, fine, adopted, tried):
    """What a simulation recorded may have steps as coarse as the search's; what is no rival of the best is not fitted again."""
    coarse, finer, fitted = searched(9.0 if tried else 2.0), searched(8.9).prepared, searched(8.8 if tried else fine).prepared
    state, finer.from_ = Search(coarse.prepared, list(tried)), lambda _: fitted
    state.prepared.finer = lambda: finer
    monkeypatch.setattr(again, "_anew", lambda _, h: left(h.left + fine - 2.0, *h.effects))
    again.refine(state)
    assert state.prepared is (fitted if adopted else coarse.prepared)
    assert [h.left for h in state.tried] == pytest.approx([1.0, 1.9, 3.5][: len(tried)] if adopted else [h.left for h in tried])


@pytest.mark.parametrize(("cost", "left_", "adopted", "away"), [
    (8.9, 1.9, True, 7.07), (8.9, 2.1, False, 7.07), (9.1, 1.9, False, 7.07), (9.5, 1.9, False, 0.5),
])  # fmt: skip
def test_the_best_is_fitted_from_far_to_either_side(monkeypatch, cost, left_, adopted, away):
    """Five standard deviations each way, inside the bounds; how far off such fits end counts unless they cost more, whichever is kept."""
    free = [Free(name, 1.0, low, np.inf, 0.0, 1.0) for name, low in (("a", -np.inf), ("b", 0.0))]
    found = Fit(tuple(free), np.array([1.0, 0.5]), (SLOPE,), np.zeros(0), np.zeros(0), 9.0, np.diag([100.0, 4.0]), 0.5)
    there = replace(found, x=found.x + [1.0, 0.0], cost=cost, away=0.0)
    state, begun = searched(9.0, Judged((SLOPE,), found, 2.0, np.ones(24), np.ones(7))), []
    state.prepared.from_ = lambda best: SimpleNamespace(base=state.base, begun=best)
    monkeypatch.setattr(again, "_from", lambda state, found, x: begun.append(x) or there)
    monkeypatch.setattr(again, "_settled", lambda _, *fits: len(fits) == 2 and Judged((SLOPE,), fits[0], left_, np.ones(24), np.ones(7)))
    again.shake(state)
    (h,) = state.tried
    assert state.prepared.begun is h.fit
    off = (np.array(begun) - found.x) * [10.0, 2.0]
    assert np.allclose(off[:, 0], 5.0 * np.random.default_rng(0).standard_normal(2)[0] * np.array([-1.0, 1.0]))
    assert min(x[1] for x in begun) > 0.0
    assert (h.left == left_, h.fit.x[0] == 2.0) == (adopted, adopted)
    assert h.fit.away == pytest.approx(away, abs=0.01)


def test_what_was_seen_of_other_minima_holds_in_finer_steps(monkeypatch):
    found = Fit((), np.zeros(2), (SLOPE,), np.zeros(0), np.zeros(0), 9.0, np.eye(2), 3.0)
    monkeypatch.setattr(again, "fit", lambda *_: replace(found, away=0.0))
    monkeypatch.setattr(again, "_settled", lambda _, again: Judged((SLOPE,), again, 1.0, np.ones(24), np.ones(7)))
    assert again._anew(searched(9.0), Judged((SLOPE,), found, 2.0, np.ones(24), np.ones(7))).fit.away == 3.0


def test_intervals_are_as_wide_as_fits_end_apart():
    """Of white residuals: the root of one and the square of how far off; never wider than what was believed beforehand."""
    readings = np.random.default_rng(0).standard_normal((16, 160))
    left_ = np.concatenate([readings, np.zeros((16, CHANGES))], 1)
    free = tuple(Free(name, 1.0, -np.inf, np.inf, 0.0, sd) for name, sd in (("a", 1.0), ("b", 0.11)))
    one = Fit(free, np.zeros(2), (), np.zeros(0), left_, 9.0, np.diag([100.0, 100.0]))
    state = searched(9.0)
    state.prepared.parts["fit"] = SimpleNamespace(observed=SimpleNamespace(angle_readings=160))
    width = [np.ptp(_intervals(state, replace(one, away=away)), axis=1) for away in (0.0, 3.0)]
    assert width[1][0] / width[0][0] == pytest.approx(np.sqrt(10.0))
    assert width[1][1] == pytest.approx(2 * NORMAL_95 * 0.11)


def test_pairs_that_look_best_are_fitted_for_good(monkeypatch):
    state, fitted = searched(9.0, left(4.0, SLOPE)), []
    cost = {FRICTION: 30.0, TETHER: 10.0, LAG: 20.0}

    class Screen:
        def __init__(self, *_) -> None:
            pass

        def singles(self):
            return [solution(c) for c in cost]

        def solve(self, pair, shapes):
            return solution(*pair, gain=0.0)

    def solution(*effects, gain=1.0):
        return SimpleNamespace(effects=effects, names=frozenset(c.name for c in effects), gain=gain, values={})

    def look(state, seen, s, *, brief=False):
        if not brief:
            fitted.append(s.effects)
        return SimpleNamespace(cost=cost[s.effects[0]] if len(s.effects) == 1 else 99.0)

    monkeypatch.setattr(looks, "Screen", Screen)
    monkeypatch.setattr(looks, "_fitted", look)
    looks.pairs(state, Screen(), [])
    assert fitted == [(TETHER,), (LAG,)]


@pytest.mark.parametrize(("best", "word"), [(FLOOR + 0.9 * LEAST, "named"), (FLOOR + 2.0 * LEAST, "unknown")])
def test_what_would_be_no_gap_alone_leaves_nothing_unknown(monkeypatch, best, word):
    """A re-tune that swallows most of an effect leaves so little that a tenth of it is less than anyone can see."""
    state = searched(FLOOR + 1.2, left(best, SLOPE))
    monkeypatch.setattr(analyse, "search", lambda *_: state)
    monkeypatch.setattr(analyse, "_evidence", lambda state: (9.0, 9.0))
    assert analyse.analyse("simple", None).word == word


@pytest.mark.parametrize(("share", "kept"), [(1.4, {"added_mass", "gravity_tilt"}), (2.9, {"gravity_tilt"}), (3.1, set())])
def test_what_acts_on_chassis_and_feet_is_fitted_from_the_model_as_given(monkeypatch, share, kept):
    """All briefly, on every second segment; for good the best two of those that leave less than half again of what the re-tune leaves."""
    state, brief, good = searched(9.0), {}, {}
    state.base.fit.free, state.base.fit.residual = (None, None), np.tile([[2.0, 1.0], [50.0, 50.0]], (4, 1))
    state.prepared.parts["fit"] = Segments(8)
    of_the_re_tune = 4 * 0.5 * (2.0**2 + 1.0**2)

    def start(replay, model):
        assert model == Setting()
        return SimpleNamespace(change=np.arange(8))

    def fit(replay, free, x, effects, begun, rounds):
        np.testing.assert_array_equal(begun, np.arange(8) if rounds == looks.ROUNDS else [0, 2, 4, 6])
        assert len(replay) == len(begun)
        (own,) = effects
        done = good if rounds == looks.ROUNDS else brief
        done[own.effect, own.place] = x[:2], [f.low < value < f.high for f, value in zip(free[2:], x[2:], strict=True)]
        shares = {"gravity_tilt": 0.5 * share, "added_mass": share}
        return SimpleNamespace(cost=shares.get(own.effect, share + 0.05) * of_the_re_tune)

    monkeypatch.setattr(looks, "start", start)
    monkeypatch.setattr(looks, "fit", fit)
    found = looks.outside(state)
    assert {effect for effect, _ in brief} == {
        "added_mass",
        "air_drag",
        "gravity_tilt",
        "ground_compliance",
        "ground_friction",
        "tether_force",
    }
    assert {place for _, place in brief} == {"chassis", "all"}
    assert all((robot == 0.0).all() and all(inside) for robot, inside in (*brief.values(), *good.values()))
    assert {effect for effect, _ in good} == kept
    assert len(found) == len(kept)


def test_responses_are_chords_inside_what_a_size_may_be():
    """Contact bends them: as long as a size may well be, and no longer than it can be; of a limit, where the largest drive passes it."""
    reach = 70.0
    jobs = screen._jobs(candidates.forms(), reach)
    sizes = [(values[column.size], c, next(p for p in c.law.sizes if p.name == column.size)) for column, c, values in jobs]
    assert all(p.low < value < p.high for value, _, p in sizes)
    assert all(value >= p.typical for value, _, p in sizes if not p.screen)
    assert all(0.8 * reach < 1.0 / (value * c.scale(p)) < reach for value, c, p in sizes if p.screen)


def test_a_limit_begins_as_far_beyond_the_drive_as_its_share_of_the_response_or_is_off():
    seen, c = object.__new__(screen.Screen), Candidate("drive_saturation", "hard", "all")
    seen._reach, (p,) = 70.0, c.law.sizes
    whole = screen._seen(c, p, seen._reach)
    limits = [1.0 / (c.scale(p) * seen._begun(c, p, share * whole)) for share in (0.1, 0.5, 1.0)]
    assert limits == pytest.approx([70.0 / (1.0 + 0.1 * share) for share in (0.1, 0.5, 1.0)])
    assert [seen._begun(c, p, share * whole) for share in (0.0, 0.04)] == [0.0, 0.0]
