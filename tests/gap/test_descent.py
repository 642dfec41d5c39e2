"""How fits step and what they believe, on one leg of HAMR-simple and on HAMR-full."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shaken_leg import FRICTION, shaken

from hamr_gap.fitting.descent import TRIALS
from hamr_gap.fitting.fit import fit
from hamr_gap.fitting.parameters import Candidate, effect_parameters
from hamr_gap.fitting.sensors import Sensors
from hamr_gap.flagship_find import recorded
from hamr_gap.legs import machine_of
from hamr_gap.naming.prepare import prepare


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
    monkeypatch.setattr("hamr_gap.fitting.descent.TRIALS", [(np.minimum(shares, 1.0), curved) for shares, curved in TRIALS])
    capped = np.array([fit(stuck.weighed, free, x).cost for x in starts])
    found = 1.05 * min(beyond.min(), capped.min())
    assert np.sum(beyond < found) > 1.5 * np.sum(capped < found)


def test_a_shift_of_the_clocks_in_the_model_is_that_of_its_sensors(rubbing):
    late = 0.3  # ms, no whole number of steps
    moved = rubbing.weighed.on_time(rubbing.weighed.model.delay + late)
    free, x = rubbing.base.fit.free, rubbing.base.fit.x
    step = rubbing.weighed.model.reading_step
    before = Sensors(np.zeros(4), np.zeros(4), late).read(rubbing.weighed.model.runs(free, x)[0], step)
    rest = late - (moved.model.delay - rubbing.weighed.model.delay)
    after = Sensors(np.zeros(4), np.zeros(4), rest).read(moved.model.runs(free, x)[0], step)
    assert np.abs(after - before)[5:-5].max() < 0.1 * rubbing.noise.min()


def test_no_sensor_changes_its_scale_to_mend_a_wrong_model():
    """Three seconds of HAMR-full seen by HAMR-simple: with priors against the noise alone an encoder's scale doubled."""
    prepared = prepare(machine_of("simple", "fl"), recorded("fl", seconds=3.0, noise=1e-3, seed=3))
    assert prepared.base.left > 100.0  # in units of the noise: a model error
    assert np.abs(prepared.base.fit.sensors.gain).max() < 0.05  # five standard deviations
