"""Intervals against closed forms, and against what happens: how many hold the truth over many draws of the noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binomtest

from hamr_dynamics.effects.law import Scales
from hamr_dynamics.machine import linear_machine
from hamr_gap.data.record import Record
from hamr_gap.fitting.fit import Fit, fit
from hamr_gap.fitting.linear import jacobian
from hamr_gap.fitting.model import Model
from hamr_gap.fitting.parameters import Candidate, Free, changes, effect_parameters
from hamr_gap.fitting.weighed import Weighed
from hamr_gap.judging.interval import NORMAL_95, intervals
from hamr_gap.naming.hypothesis import judge, settled

MASS = linear_machine("test_interval", inertia=1.0, stiffness=900.0, damping=6.0, joint="mass")
CUBIC = Candidate("cubic_stiffness", "cubic", (0,))
GAIN = Free("change.gain.0", 1.0, -0.95, np.inf, 0.0, 0.5)
N = 3000
SCALES = Scales(force=300.0, coordinate=0.4, time=1.0 / 30.0, drive=300.0, span=6.0)


def driven(noise: float, seed: int, *, cubic: float = 0.2) -> tuple[Weighed, tuple[Free, ...], np.ndarray]:
    """A spring under noise, read with noise (a share of its motion); what is free, and its true values."""
    drives = 400.0 * np.convolve(np.random.default_rng(1).standard_normal(N + 30), np.hanning(31) / 8.0, "valid")[:, None]
    empty = Model(MASS, Record(drives, np.zeros((N, 1)), 2e-3, ("mass",), held=True), 2, 1, SCALES)
    free = (*changes(MASS, SCALES, (True,)), *effect_parameters([CUBIC], SCALES))
    true = {"change.stiffness.0": 0.12, "change.inertia.0": -0.03, "cubic_stiffness.cubic.cubic.0": cubic}
    x = np.array([true.get(f.row, 0.0) for f in free])
    truth = empty.runs(free, x)[0]
    sigma = noise * truth.std()
    read = truth + sigma * np.random.default_rng(seed).standard_normal(truth.shape)
    model = Model(MASS, Record(drives, read, 2e-3, ("mass",), held=True), 2, 1, SCALES)
    return Weighed(model, np.ones(read.shape, bool), np.array([sigma]), (), model), free, x


def test_what_makes_up_for_each_other_is_known_by_belief_alone():
    """A drive twice as strong on a machine twice as heavy, stiff and damped does the same: only priors tell, however good the data."""
    weighed, free, _ = driven(1e-5, 0, cubic=0.0)
    free = (GAIN, *(f for f in free if f.row.startswith("change")))
    found = fit(weighed, free, np.zeros(len(free)), tolerance=0.0)
    own = {"gain": 1.0, "stiffness": 900.0, "inertia": 1.0, "damping": 6.0, "preload": 0.0}
    along = found.x + np.array([own[f.row.split(".")[1]] / f.scale for f in free])
    unsure = 1.0 / np.sqrt(np.sum((along / [f.sd for f in free]) ** 2))
    low, high = intervals(weighed, found).T
    sure = along != found.x  # the preload
    assert (high - low)[sure] / 2 == pytest.approx(NORMAL_95 * unsure * along[sure], rel=0.05)


def test_of_what_diverges_with_the_least_change_the_prior_alone_is_known(monkeypatch):
    weighed, free, _ = driven(1e-3, 0)
    found = fit(weighed, free, np.array([f.center for f in free]))
    usual = intervals(weighed, found)

    def diverging(*about):
        return np.where(np.arange(len(free) + weighed.sensor_precision.size) == 1, np.inf, jacobian(*about))

    monkeypatch.setattr("hamr_gap.judging.interval.jacobian", diverging)
    monkeypatch.setattr("hamr_gap.judging.interval._together", lambda *_: np.full(1, np.nan))  # diverges as well
    low, high = intervals(weighed, found).T
    assert np.isfinite([low, high]).all()
    believed = found.x[1] + NORMAL_95 * free[1].sd * np.array([-1.0, 1.0])
    assert [low[1], high[1]] == pytest.approx(np.clip(believed, free[1].low, free[1].high))
    assert (high - low)[1] > 10 * np.diff(usual)[1, 0]
    assert np.all((high - low)[2:] < 1.01 * np.diff(usual)[2:, 0])


def test_no_interval_leaves_the_bounds():
    weighed, free, _ = driven(0.3, 0, cubic=0.0)
    (row,) = (k for k, f in enumerate(free) if f.row.startswith("cubic"))
    free = (*free[:row], replace(free[row], low=-0.01, high=0.01), *free[row + 1 :])
    found = fit(weighed, free, np.array([f.center for f in free]))
    bounds = intervals(weighed, found)
    assert bounds[row] == pytest.approx([-0.01, 0.01])
    assert (bounds[:, 0] <= found.x).all() and (found.x <= bounds[:, 1]).all()


def test_intervals_hold_the_truth_as_often_as_they_say():
    hits = []
    for seed in range(40):
        weighed, free, x = driven(0.01, seed)
        begun = fit(weighed, free, np.array([f.center for f in free]))
        found = settled(weighed, weighed.chosen, judge(weighed, weighed.chosen, (CUBIC,), begun)).fit
        low, high = intervals(weighed, found).T
        told = [not f.row.startswith("change.preload") for f in free]  # beside a bias, belief alone
        hits.extend(((low <= x) & (x <= high))[told])
    interval = binomtest(sum(hits), len(hits)).proportion_ci(0.99, "exact")
    assert interval.low < 0.95 < interval.high


def test_what_is_stated_is_fitted_to_the_end_and_what_is_pinned_stays():
    weighed, free, _ = driven(0.01, 5)
    begun = fit(weighed, free, np.array([f.center for f in free]), steps=2)
    h = judge(weighed, weighed.chosen, (CUBIC,), begun)
    best = fit(weighed, free, begun.x, tolerance=0.0).cost
    assert begun.cost > best + 1.0
    assert settled(weighed, weighed.chosen, h).fit.cost == pytest.approx(best, abs=0.1)
    pinned = judge(weighed, weighed.chosen, (CUBIC,), replace(begun, free=(replace(free[0], low=0.0, high=0.0), *free[1:])))
    assert settled(weighed, weighed.chosen, pinned) is pinned


def test_an_interval_on_a_bound_is_still_one():
    weighed, free, _ = driven(0.01, 3)
    held = tuple(Free(f.row, f.scale, 0.0, f.high, f.center, f.sd) if f.row.startswith("change.inertia") else f for f in free)
    found: Fit = fit(weighed, held, np.zeros(len(held)))
    at = [f.row.startswith("change.inertia") for f in held]
    assert found.x[at] == 0.0
    low, high = intervals(weighed, found).T
    assert np.isfinite(high - low).all()
    assert ((high - low) > 0.0).all()
