"""An arm that is driven over its top: what differs a little at the start of a piece soon differs much, and only short pieces tell."""

from __future__ import annotations

import math
import warnings
from dataclasses import replace

import numpy as np
import pytest
from hanging import hanging
from scipy.signal import butter, cont2discrete, lfilter, sosfilt

from hamr_dynamics.machine import linear_machine
from hamr_gap.data.record import Record
from hamr_gap.fitting.initial_states import InitialStates
from hamr_gap.fitting.model import Model
from hamr_gap.fitting.scales import scales_of
from hamr_gap.judging.analyse import analyse
from hamr_gap.naming.prepare import prepare

INERTIA, WEIGHT, DAMPING, STEP = 0.06, 1.0, 0.01, 5e-3  # kg m^2, N m at a right angle, N m s, s
NOISE = 2e-3  # rad
ARM = hanging("tipping", inertia=INERTIA, weight=WEIGHT, damping=DAMPING)


def driven(seconds: float, *, friction: float, torque: float, seed: int) -> Record:
    """Slow noise of so much torque (N m rms), held between samples, against dry friction (N m), by small steps of no library."""
    random, fine = np.random.default_rng(seed), 20
    u = sosfilt(butter(2, 3.0, fs=1.0 / STEP, output="sos"), random.standard_normal(int(seconds / STEP)))
    u *= torque / u.std()
    q, v, seen = 0.0, 0.0, np.empty(len(u))
    for i, push in enumerate(u.tolist()):
        seen[i] = q
        for _ in range(fine):
            v += STEP / fine * (push - WEIGHT * math.sin(q) - DAMPING * v - friction * math.tanh(v / 0.01)) / INERTIA
            q += STEP / fine * v
    return Record(u[:, None], (seen + NOISE * random.standard_normal(len(u)))[:, None], STEP, ("arm",), held=True, rest=False)


WAYS = [(0.0, np.ones_like), (4.0, lambda t: np.cos(2.0 * t)), (-4.0, lambda t: np.cosh(2.0 * t))]


@pytest.mark.parametrize(("stiffness", "moved"), WAYS)
def test_starts_part_as_fast_as_a_linear_machine_says(stiffness, moved):
    """Of a mass they stay as far apart, on a spring they swing, and upside down they part."""
    machine, time = linear_machine("mass", inertia=1.0, stiffness=stiffness), STEP * np.arange(5000)
    record = Record(np.sin(7.0 * time)[:, None], np.sin(time)[:, None], STEP, ("joint",), rest=False)
    model = Model(machine, record, 4, 1, scales_of(machine, record), 3.0)
    whole = (model.pieces.stop - model.pieces.first) * STEP
    begun = np.linspace(0.0, whole // STEP // 4 * STEP, 500)
    apart = [np.sqrt(np.mean(moved(t) ** 2, axis=0)) for t in (begun, whole - begun)]
    about = InitialStates.about(model, model.rows((), np.zeros(0))[0], np.ones(1))
    assert about.growth[:, 0] == pytest.approx(apart[1] / apart[0], rel=0.02)
    with warnings.catch_warnings(action="error"):  # a run that diverges stays so, and nobody is warned
        assert not np.isfinite(about.beside(np.full_like(model.target, np.inf))).all()


@pytest.mark.parametrize("seed", [0, 1])
def test_an_arm_that_tips_over_is_run_in_pieces_that_can_be_foreseen(seed):
    """In sixteen pieces of 2.5 s errors grow up to fifty-fold, and nothing is named, or three effects are."""
    record = driven(40.0, friction=0.1, torque=1.0, seed=seed)
    assert np.ptp(record.readings) > 4.0 * math.pi
    found = analyse(ARM, record)
    weighed = found.prepared.weighed
    assert weighed.model.record.held and np.quantile(weighed.initial.growth, 0.9) < 4.0
    assert found.verdict.verdict == "named"
    (effect,) = found.verdict.set[0].effects
    assert effect.effect == "coulomb_friction" and effect.parameters["level"]["arm"].value == pytest.approx(0.1, rel=0.05)


@pytest.mark.parametrize("seed", [0, 3])
def test_half_a_sample_of_a_held_drive_is_no_lag(seed):
    """Without friction the model leaves less of a drive that is smooth between samples; with it, of the one that was held."""
    found = analyse(ARM, driven(20.0, friction=0.05, torque=0.5, seed=seed))
    assert found.prepared.weighed.model.record.held
    assert found.verdict.verdict == "named" and [e.effect for e in found.verdict.set[0].effects] == ["coulomb_friction"]


def test_a_driver_whose_hold_is_known_is_not_asked_again():
    """The same, from a driver that is known to be a hundred times faster than the samples: smooth it stays, whatever it costs."""
    record = replace(driven(20.0, friction=0.05, torque=0.5, seed=0), hold=STEP / 100)
    assert not analyse(ARM, record).prepared.weighed.model.record.held


@pytest.mark.parametrize(("gusts", "least", "most"), [(0.0, 16, 16), (1.0, 32, 200)])
def test_pieces_are_short_where_what_nobody_measured_moves_as_much_as_the_drive(gusts, least, most):
    """A swing in the wind: over 2.5 s the model says next to nothing, over a fraction of a second most of it."""
    random, n = np.random.default_rng(2), int(40.0 / STEP)
    force = sosfilt(butter(2, 2.0, fs=1.0 / STEP, output="sos"), random.standard_normal((2, n)))
    drive, wind = force / force.std(1, keepdims=True)
    b, a, *_ = cont2discrete(([1.0], [1.0, 0.4, 16.0]), STEP)
    seen = lfilter(b[0], a, drive + gusts * wind) + 1e-3 * random.standard_normal(n)
    record = Record(drive[:, None], seen[:, None], STEP, ("joint",), held=True, rest=False)
    prepared = prepare(linear_machine("swing", inertia=1.0, stiffness=16.0, damping=0.4), record)
    assert least <= len(prepared.weighed.model.pieces) <= most
