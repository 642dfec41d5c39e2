"""A drive whose gain wanders over a run, found by periods that were screened one by one."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.signal import butter, sosfilt

from hamr_dynamics.effects.law import powers
from hamr_dynamics.effects.library import library
from hamr_dynamics.machine import linear_machine
from hamr_gap.data.record import Record
from hamr_gap.fitting.parameters import Candidate
from hamr_gap.judging.analyse import analyse
from hamr_gap.naming.hypothesis import refine, starts
from hamr_gap.naming.moves import FOLLOWED, SHAPES, in_other_shapes, look
from hamr_gap.naming.prepare import prepare
from hamr_gap.naming.screen import screen

MASS = linear_machine("mass", inertia=1.0, stiffness=900.0, damping=6.0, joint="mass")
WAVES = Candidate("drive_drift", "waves", (0,))


def test_slow_is_what_is_slow_beside_the_run():
    """However fast the machine: no drift is measured in the machine's own time."""
    letters = {letter for form in library()["drive_drift"].forms for p in form.parameters for letter, _ in powers(p.dimension)}
    assert letters == {"S", "U"}


@cache
def wandering(fast: float) -> Record:
    """30 s of a spring driven by noise, with a gain of two waves of 17 s and another period, by steps that know nothing of the library."""
    step, fine, n, q, v = 5e-3, 20, 6000, 0.0, 0.0
    random = np.random.default_rng(2)
    drive = 300.0 * sosfilt(butter(3, 8.0, fs=1.0 / step, output="sos"), random.standard_normal(n))
    seen, h = np.empty(n), step / fine
    for i, u in enumerate(drive):
        seen[i] = q
        for k in range(fine):
            turn = 2.0 * np.pi * step * (i + k / fine) / 17.0
            gain = 1.0 + 0.02 * (np.sin(turn + 1.2) + 0.5 * np.sin(turn * 17.0 / fast))
            v += h * (gain * u - 900.0 * q - 6.0 * v)
            q += h * v
    read = seen + 1e-3 * seen.std() * random.standard_normal(n)
    return Record(drive[:, None], read[:, None], step, ("mass",), held=True)


@pytest.mark.parametrize("period", [5.1, 2.3])
def test_each_wave_is_simulated_once_and_both_periods_are_seen(period):
    prepared = prepare(MASS, wandering(period))
    seen = screen(prepared.weighed, prepared.base.fit, [WAVES], amplitude=5.0)
    slow, fast = (len(p.screen) for p in WAVES.law.shapes)
    assert len(seen.columns) == 2 * (slow + fast)
    assert len(seen.options(WAVES)) == slow * fast
    (best,) = seen.best(WAVES)
    shapes = dict(shape for c in best.chosen for shape in seen.columns[c].shapes)
    spans = [shapes[WAVES.row(p, 0)] * 30.0 for p in WAVES.law.shapes]
    assert spans == pytest.approx([17.0, period], rel=0.25)


@pytest.mark.parametrize(("period", "windows", "width"), [(2.3, 8, 40), (7.1, 5, 60)])
def test_waves_that_only_pass_through_what_is_fitted_are_told_by_trying_others(period, windows, width):
    """From a few short windows: the first fits explain those and nothing between them."""
    prepared = prepare(MASS, wandering(period))
    chosen = np.zeros(prepared.weighed.chosen.shape, bool)
    for k in range(windows):
        start = int((k + 0.5) / windows * len(chosen))
        chosen[start : start + width] = True
    weighed, base = replace(prepared.weighed, chosen=chosen), prepared.base.fit
    seen = look(weighed, base, [WAVES])
    tried = [refine(weighed, prepared.judged, s) for s in starts(weighed, base, seen, [((WAVES,), s) for s in seen.best(WAVES, SHAPES)])]
    first = min(tried, key=lambda h: h.fit.cost)
    others = in_other_shapes(weighed, prepared.judged, base, seen, tried)
    best = min(others, key=lambda h: h.fit.cost)
    assert first.left > 50.0
    assert best.left < 4.0
    assert len(others) <= FOLLOWED
    assert best.fit.x[[f.row.endswith("fast_period.0") for f in best.fit.free]] * 30.0 == pytest.approx(period, rel=0.05)


def test_a_law_of_few_shapes_is_not_tried_again():
    prepared = prepare(MASS, wandering(5.1))
    stop = Candidate("end_stop", "both", (0,))
    seen = look(prepared.weighed, prepared.base.fit, [stop])
    (start,) = starts(prepared.weighed, prepared.base.fit, seen, [((stop,), seen.best(stop)[0])])
    tried = [refine(prepared.weighed, prepared.judged, start)]
    assert in_other_shapes(prepared.weighed, prepared.judged, prepared.base.fit, seen, tried) == []


def test_a_gain_that_wanders_is_named():
    verdict = analyse(MASS, wandering(5.1)).verdict
    assert verdict.verdict == "named"
    (effect,) = verdict.set[0].effects
    assert (effect.effect, effect.form) == ("drive_drift", "waves")
    found = {name: effect.parameters[name]["mass"].value for name in ("slow_period", "fast_period")}
    assert found == {"slow_period": pytest.approx(17.0, rel=0.05), "fast_period": pytest.approx(5.1, rel=0.02)}
    assert effect.parameters["slow_period"]["mass"].unit == "s"
