"""The walking study's parts: turns, smoothed and fitted starts, roles, settings."""

from __future__ import annotations

import warnings
from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from walks import STEP, walked

from hamr_description.errors import BagError
from hamr_gap.fitting import threads
from hamr_gap.walking import fit as fits
from hamr_gap.walking import robot
from hamr_gap.walking.fit import SETTLING, Fit, fit, kept
from hamr_gap.walking.left import trimmed
from hamr_gap.walking.prepare import settled
from hamr_gap.walking.replay import Replay
from hamr_gap.walking.robot import Numerics, Robot
from hamr_gap.walking.roles import TURN_MS, TURNS, roles
from hamr_gap.walking.segments import CHANGES, apart, segments
from hamr_gap.walking.setting import Candidate, Setting, effect_parameters, retune, setting
from hamr_gap.walking.starts import start
from hamr_gap.walking.walk import Walk, joined, product, turn_between, turned


@given(st.lists(st.floats(-1.5, 1.5), min_size=6, max_size=6))
def test_turns_are_those_of_rotations(numbers):
    a, b = np.array(numbers[:3]), np.array(numbers[3:])
    start_, end = turned(np.array([1.0, 0, 0, 0]), a), turned(turned(np.array([1.0, 0, 0, 0]), a), b)
    true = Rotation.from_rotvec(a) * Rotation.from_rotvec(b)
    assert np.allclose(Rotation.from_quat(np.roll(end, -1)).as_matrix(), true.as_matrix(), atol=1e-12)
    assert np.allclose(turn_between(start_, end), b, atol=1e-12)
    assert np.allclose(product(start_, start_ * [1, -1, -1, -1]), [1, 0, 0, 0], atol=1e-12)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 1000))
def test_starts_of_smooth_motion_are_exact(seed):
    """A polynomial of the degree that is fitted comes back with its slopes, whatever the poses' times."""
    rng = np.random.default_rng(seed)
    t = np.arange(2000) * STEP
    slow = rng.normal(0, 1e-3, (2, 3, 3))
    path = sum(slow[0, k] * (t[::16, None] - 250.0) ** k / 100.0 ** max(0, k - 1) for k in range(3))
    spin = np.array([0.0, 0.0, 2e-4])
    quaternion = turned(np.array([1.0, 0, 0, 0]), spin * t[::16, None])
    angles = np.sin(t[:, None] / 300.0 + np.arange(8)) * 0.1
    walk = Walk(np.full((2000, 8), 112.5), angles, STEP, np.arange(0, 2000, 16), path, quaternion)
    found = segments(walk, length_ms=20.0, every_ms=20.0)
    at = found.first * STEP
    assert np.allclose(found.starts[:, 0:3], path[found.first // 16], atol=1e-9)
    velocity = slow[0, 1] + 2 * slow[0, 2] * (at[:, None] - 250.0) / 100.0
    assert np.allclose(found.starts[:, 7:10], velocity, atol=1e-9)
    assert np.allclose(found.starts[:, 10:13], spin, atol=1e-9)
    assert np.allclose(found.starts[:, 21:29], np.cos(at[:, None] / 300.0 + np.arange(8)) * 0.1 / 300.0, rtol=1e-4, atol=1e-9)


def test_no_segment_bridges_a_break_or_lost_poses():
    walk, _ = walked()
    two = joined([walk, walk])
    found = segments(two, length_ms=20.0, every_ms=20.0)
    seam = len(walk.angles)
    for one in (found, found.before):
        assert not ((one.first < seam) & (one.first + one.samples >= seam)).any()
    assert np.array_equal(found.before.first + found.before.samples, found.first)
    gap = Walk(walk.voltages, walk.angles, STEP, np.delete(walk.seen, slice(100, 110)), np.delete(walk.position, slice(100, 110), 0),
               np.delete(walk.quaternion, slice(100, 110), 0))  # fmt: skip
    first = segments(gap, length_ms=20.0, every_ms=20.0).first
    assert not ((first > 16 * 97) & (first < 16 * 112)).any()


def test_roles_never_share_a_turn_and_short_walks_are_refused():
    walk, _ = walked()
    whole = segments(joined([walk] * 8), length_ms=40.0, every_ms=40.0)
    part = roles(whole)
    turn = {role: set((whole.first[index] - whole.first[0]) * STEP // TURN_MS) for role, index in part.items()}
    assert set(turn) == set(TURNS)
    assert not any(turn[a] & turn[b] for a in turn for b in turn if a != b)
    with pytest.raises(BagError, match="record 4 s or more"):
        roles(segments(walk, length_ms=40.0, every_ms=40.0))


def test_a_walk_without_poses_or_with_lost_angles_is_refused():
    walk, _ = walked()
    with pytest.raises(BagError, match="hardly ever seen"):
        Walk(walk.voltages, walk.angles, STEP, walk.seen[:1], walk.position[:1], walk.quaternion[:1])
    with pytest.raises(BagError, match="were lost"):
        Walk(walk.voltages, np.where(walk.angles == walk.angles[5], np.nan, walk.angles), STEP, walk.seen, walk.position, walk.quaternion)


def test_fitted_starts_predict_to_the_noise_where_smoothed_ones_do_not():
    """Same ground: what fitted starts leave is what true starts leave, and a small part of what smoothed ones do."""
    walk, states = walked()
    chosen = segments(walk, length_ms=20.0, every_ms=40.0)
    replay = Replay.of(Robot("simple", Numerics(1, 0.1)), chosen)
    smoothed = replay.each(np.zeros((len(chosen), CHANGES)), [Setting()])[0][:, :-CHANGES]
    fitted = start(replay, Setting()).residual[:, :-CHANGES]
    true = states[chosen.first // 16]
    runs = replay.robot.run(true, replay.observed.drives, [Setting()], np.zeros(len(chosen), int), np.arange(len(chosen)))
    from_true = replay.observed.residual(true, runs, np.zeros((len(chosen), 11)), np.zeros((len(chosen), 8)), np.arange(len(chosen)))
    assert trimmed(fitted)[0] < 0.1 * trimmed(smoothed)[0]
    assert trimmed(fitted)[0] < 1.2 * trimmed(from_true)[0]
    assert trimmed(fitted)[0] < 6.0  # of means over 1 ms: an angle is a noise or so off


def test_starts_anew_stand_where_true_ones_do():
    """Feet that smoothing puts wrongly are put right by what they did before: few segments end elsewhere than from true starts."""
    walk, states = walked()
    chosen = segments(walk, length_ms=20.0, every_ms=20.0)
    replay = Replay.of(Robot("simple", Numerics(1, 0.1)), chosen)
    true = start(replay, Setting(), apart(chosen.starts, states[chosen.first // 16]) / chosen.sd)
    anew = start(replay, Setting())
    assert np.mean(anew.cost > 1.3 * true.cost) < 0.1
    assert anew.cost.sum() < 1.1 * true.cost.sum()


def test_a_run_that_diverges_on_the_way_to_a_segment_costs_nothing(monkeypatch):
    """Starts are then what smoothing makes of them."""
    walk, _ = walked()
    replay = Replay.of(Robot("simple", Numerics(1, 0.1)), segments(walk, length_ms=8.0, every_ms=120.0))
    monkeypatch.setattr(Replay, "ends", lambda self, change, model: np.full((len(self), 29), np.nan))
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # of sums with what is no number
        assert np.isfinite(start(replay, Setting()).cost).all()


def test_runs_end_where_they_go_on():
    walk, _ = walked()
    chosen = segments(walk, length_ms=20.0, every_ms=120.0)
    robot_, some = Robot("simple"), np.arange(len(chosen))
    lead = Replay.of(robot_, chosen.before)
    there = lead.ends(np.zeros((len(chosen), CHANGES)), Setting())
    both = replace(chosen.before, samples=chosen.before.samples + chosen.samples)
    whole, after = (robot_.run(x, Replay.of(robot_, part).observed.drives, [Setting()], 0 * some, some)
                    for x, part in ((chosen.before.starts, both), (there, chosen)))  # fmt: skip
    assert np.allclose(whole.position[:, -chosen.samples :], after.position, rtol=0.0, atol=1e-4)
    assert np.abs(apart(whole.ends, after.ends) / chosen.sd).max() < 0.01  # contact makes rounding grow, by less than anyone can see


def test_half_the_steps_come_nearer():
    """Each halving moves readings by less than the one before."""
    replay = Replay.of(Robot("simple"), segments(walked()[0], length_ms=8.0, every_ms=120.0))
    change, read = np.zeros((len(replay), CHANGES)), []
    for robot_ in (replay.robot, replay.robot.finer(), replay.robot.finer().finer()):
        read.append(Replay.of(robot_, replay.segments).each(change, [Setting()])[0])
    first, second = (np.median(np.abs(b - a).max(1)) for a, b in pairwise(read))
    assert 0.0 < second < first


def test_a_brief_fit_takes_the_slopes_that_it_is_given(monkeypatch):
    walk, _ = walked()
    replay = Replay.of(Robot("simple", Numerics(1, 0.1)), segments(walk, length_ms=8.0, every_ms=120.0))
    free = retune(replay.robot.rest())[:8]
    x = np.full(len(free), 0.1)
    begun = start(replay, setting(free, x))
    slopes = replay.slopes(begun.change, begun.residual, setting(free, x))
    monkeypatch.setattr(Replay, "slopes", None)
    assert fit(replay, free, x, (), begun.change, slopes=slopes, rounds=3).cost < 0.9 * begun.cost.sum()


def test_starts_anew_know_of_the_sensors_errors():
    """Sensors that are off, in a model that says so, change nothing."""
    walk, _ = walked()
    zeros, gains = np.r_[0.1, 0.01, -0.02, 0.02 * np.resize([1.0, -1.0], 8)], 0.02 * np.resize([1.0, 1.0, -1.0], 8)
    position = walk.position + zeros[0] * np.array([0.0, 0.0, 1.0])
    off = Walk(walk.voltages, walk.angles * (1.0 + gains) + zeros[3:], STEP, walk.seen, position,
               turned(walk.quaternion, np.r_[zeros[1:3], 0.0]))  # fmt: skip
    robot_, model = Robot("simple", Numerics(1, 0.1)), Setting(zeros=tuple(zeros), gains=tuple(gains))
    plain = start(Replay.of(robot_, segments(walk, length_ms=20.0, every_ms=60.0)), Setting())
    there = start(Replay.of(robot_, segments(off, length_ms=20.0, every_ms=60.0)), model)
    assert there.cost.sum() < 1.1 * plain.cost.sum()


@cache
def seen_coarsely() -> Replay:
    """Segments seen by encoders of 3 mrad."""
    walk, _ = walked()
    angles = walk.angles + np.random.default_rng(3).normal(0, 3e-3, walk.angles.shape)
    walk = Walk(walk.voltages, angles, STEP, walk.seen, walk.position, walk.quaternion)
    return Replay.of(Robot("simple", Numerics(1, 0.1)), segments(walk, length_ms=12.0, every_ms=80.0))


def far_off(seed: int = 2) -> tuple[Replay, list, np.ndarray]:
    """These, a re-tune's numbers, and those of the robot off by half of what is thought possible."""
    replay = seen_coarsely()
    free = retune(replay.robot.rest())
    own = np.array([0.5 * f.sd * f.row.startswith("change.") for f in free])
    return replay, free, own * np.random.default_rng(seed).standard_normal(len(free))


def test_a_fit_from_far_off_ends_where_one_from_the_truth_does():
    replay, free, far = far_off()
    from_truth, from_far = (settled(replay, fit(replay, free, x, (), start(replay, setting(free, x)).change)) for x in (0.0 * far, far))
    assert from_far.cost < 1.1 * from_truth.cost


def test_of_fits_that_cost_the_same_the_distance_is_known():
    """Two standard deviations along one of two numbers are the root of two over both; a fit that costs more says nothing."""
    first, same, worse = (
        Fit((), np.array([x, 0.0]), (), np.zeros(0), np.zeros(0), cost, np.diag([4.0, 1.0]), away)
        for x, cost, away in ((0.5, 100.0, 0.1), (-0.5, 101.0, 0.2), (9.0, 103.0, 8.0))
    )
    best = kept(worse, same, first)
    assert (best.x[0], best.cost) == (0.5, 100.0)
    assert best.away == pytest.approx(np.sqrt(2.0))
    assert kept(first).away == 0.1
    assert kept(first, replace(same, x=first.x)).away == 0.2  # what was known of either still holds


def test_starts_settle_before_a_step_is_judged(monkeypatch):
    """Contact bends what starts follow: without that, good steps look wrong, and two rounds of a fit get less far.

    One beginning says little: contact turns what rounding leaves into other ways down. Six speak together.
    """
    gained = []
    for seed in range(2, 8):
        replay, free, far = far_off(seed)
        begun, cost = start(replay, setting(free, far)).change, {}
        for settling in (SETTLING, 0):
            monkeypatch.setattr(fits, "SETTLING", settling)
            cost[settling] = fit(replay, free, far, (), begun, rounds=2).cost
        gained.append(cost[SETTLING] / cost[0])
    assert np.exp(np.mean(np.log(gained))) < 0.8


def test_runs_that_diverge_say_nothing_and_spoil_nothing(monkeypatch):
    """One segment diverges under every model, another on the way along one number: the fit goes where the others lead."""
    replay, free, far = far_off()
    begun, residual = start(replay, setting(free, far)).change, Replay.residual
    lost, astray = 2, setting(free, far + 0.1 * free[0].sd * (np.arange(len(free)) == 0))

    def diverging(self, change, settings, which, segment):
        found = residual(self, change, settings, which, segment)
        off = np.array([s == astray for s in settings])[which] & (segment == 5)
        found[off | (segment == lost)] = np.inf
        return found

    monkeypatch.setattr(Replay, "residual", diverging)
    found = fit(replay, free, far, (), begun, rounds=2)
    assert np.isfinite(found.x).all()
    others = np.arange(len(replay)) != lost
    assert np.sum(found.residual[others] ** 2) < 0.8 * np.sum(start(replay, setting(free, far)).residual[others] ** 2)


def test_settings_carry_every_free_number_once():
    candidate = Candidate("coulomb_friction", "sign", "swing")
    rest = {"stiffness": (0.5, 0.6), "damping": (0.03, 0.04), "inertia": (1.0, 2.0)}
    free = [*retune(rest), *effect_parameters([candidate])]
    x = np.arange(1, len(free) + 1) * 1e-3
    model = setting(free, x, [candidate])
    values = dict(zip((f.row for f in free), x, strict=True))
    assert model.shift == pytest.approx(0.25 * values["shift"])
    assert model.zeros[0] == pytest.approx(0.2 * values["zero.height"])
    assert model.gains[3] == pytest.approx(0.01 * values["gain.rl_lift"])
    changes = {(c.change, c.joints): c.value for c in model.effects.changes}
    assert changes["stiffness", ("rr_lift",)] == pytest.approx(0.6e-3 * values["change.stiffness.rr_lift"])
    assert changes["gain", ("fl_swing",)] == pytest.approx(values["change.gain.fl_swing"])
    assert len(model.effects.changes) == 40
    assert model.effects.effects[0].joints == ("fl_swing", "rl_swing", "fr_swing", "rr_swing")


def test_robots_that_share_a_block_do_as_they_do_alone():
    """Kernels pass over laws that no lane of a block uses; what others use, and what is off, changes nothing."""
    walk, _ = walked()
    chosen = segments(walk, length_ms=8.0, every_ms=160.0).some(np.arange(5))
    replay = Replay.of(Robot("simple"), chosen)
    laws = (("coulomb_friction", "sign"), ("drive_lag", "first_order"), ("cubic_stiffness", "cubic"))
    one, *others = (Candidate(effect, form, "all") for effect, form in laws)
    models = [setting(free := effect_parameters([c]), np.array([f.center or 0.2 for f in free]), [c]) for c in (one, *others)]
    free = effect_parameters([one])
    models.append(setting(free, np.array([f.center or 0.2 for f in free]), [one, *others]))  # the others are off
    still = np.zeros((len(chosen), CHANGES))
    together, plain = replay.each(still, models), replay.each(still, [Setting()])[0]
    for model, found in zip(models, together, strict=True):
        assert np.allclose(found, replay.each(still, [model])[0], atol=1e-6)
    assert np.abs(together[0] - plain).max() > 1.0
    assert np.allclose(together[0], together[-1], atol=1e-6)


def test_how_many_lanes_and_threads_there_are_changes_nothing(monkeypatch):
    walk, _ = walked()
    chosen = segments(walk, length_ms=8.0, every_ms=160.0).some(np.arange(5))
    free = effect_parameters([Candidate("drive_lag", "first_order", "all")])
    models = [Setting(), Setting(shift=0.3), setting(free, np.array([0.5]), [Candidate("drive_lag", "first_order", "all")])] * 5
    still = np.zeros((len(chosen), CHANGES))
    once = Replay.of(Robot("simple"), chosen).each(still, models)
    monkeypatch.setattr(robot, "LANES", 16)
    monkeypatch.setattr(threads, "_count", 3)
    parted = Replay.of(Robot("simple"), chosen)
    for _ in range(2):  # what a simulator did before leaves nothing behind
        assert np.array_equal(parted.each(still, models), once)
    assert np.abs(once[1] - once[0]).max() > 1.0
    assert np.abs(once[2] - once[0]).max() > 1.0
