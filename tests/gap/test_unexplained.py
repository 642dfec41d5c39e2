"""What two sensors of a joint must both show, that it be motion: against noise of their own that is slow and large."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, cont2discrete, lfilter, sosfilt

from hamr_dynamics.machine import linear_machine
from hamr_gap.data.record import Record
from hamr_gap.judging.analyse import analyse
from hamr_gap.judging.unexplained import shared, structural
from hamr_gap.naming.blocks import THROUGHOUT
from hamr_gap.naming.prepare import prepare

LINE = linear_machine("mass", inertia=1.0, stiffness=900.0, damping=6.0, joint="mass")
MASS = replace(LINE, name="both_sides", channels=("mass", "motor"), outputs=lambda q, slip: (q[0], q[0] + slip[0]))
STEP, N, KEEP = 2e-3, 12_000, np.exp(-1.0 / 30.0)


def seen(random: np.random.Generator, shaken: float) -> Record:
    """24 s of a spring by its exact motion, read on both sides, each with correlated noise; a shaker moves it besides (N rms)."""
    drive = sosfilt(butter(3, 10.0, fs=1.0 / STEP, output="sos"), random.standard_normal(N))
    drive *= 40.0 / drive.std()
    b, a, *_ = cont2discrete(([1.0], [1.0, 6.0, 900.0]), STEP)
    moved = lfilter(b[0], a, drive + shaken * np.sqrt(2.0) * np.sin(2.0 * np.pi * 3.3 * STEP * np.arange(N)))
    noise = lfilter([np.sqrt(1.0 - KEEP**2)], [1.0, -KEEP], random.standard_normal((N, 2)), axis=0)
    return Record(drive[:, None], moved[:, None] + 5e-3 * moved.std() * noise, STEP, MASS.channels[:2], held=True)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("shaken", "motion"), [(0.0, False), (0.5, True)])
def test_slow_noise_of_two_sensors_is_no_motion(seed, shaken, motion):
    prepared = prepare(MASS, seen(np.random.default_rng(seed), shaken))
    judged, found = prepared.judged, prepared.base.fit
    assert prepared.base.left > 2.0  # either way far more than what differs from sample to sample
    assert len(shared(prepared.weighed, judged, found)) > 5
    assert structural(prepared.weighed, judged, found) == motion


def kicked(kicks: float, lag: float, lasting: float = 0.5) -> Record:
    """24 s of the same, through a drive that lags (s) and with white noise; kicks (N) for half a second, or longer, in every six."""
    random, time = np.random.default_rng(1), STEP * np.arange(N)
    drive = sosfilt(butter(3, 10.0, fs=1.0 / STEP, output="sos"), random.standard_normal(N))
    drive *= 40.0 / drive.std()
    b, a, *_ = cont2discrete(([1.0], [1.0, 6.0, 900.0]), STEP)
    keep = np.exp(-STEP / lag) if lag else 0.0
    beside = np.where(time % 6.0 < lasting, kicks, 0.0) * np.sin(2.0 * np.pi * 3.3 * time)
    moved = lfilter(b[0], a, lfilter([1.0 - keep], [1.0, -keep], drive) + beside)
    noisy = moved[:, None] + 5e-3 * moved.std() * random.standard_normal((N, 2))
    return Record(drive[:, None], noisy, STEP, MASS.channels[:2], held=True)


def test_clocks_that_seem_late_where_no_effect_helps_are_no_reason_to_stop():
    """A lag that a shift of the clocks takes up, beside kicks that no name is near."""
    assert analyse(MASS, kicked(40.0, 0.02)).verdict.verdict == "unknown"


@pytest.mark.parametrize(("kicks", "lasting", "more"), [(4.0, 2.0, True), (10.0, 0.5, False), (1.0, 2.0, False)])
def test_one_sensor_that_often_shows_far_more_than_noise_shows_motion(kicks, lasting, more):
    """In a third of the time; seldom it may be a hit that comes a little late, and a little of it coloured noise."""
    both = kicked(kicks, 0.0, lasting)
    prepared = prepare(LINE, replace(both, readings=both.readings[:, :1], channels=("mass",)))
    assert not len(shared(prepared.weighed, prepared.judged, prepared.base.fit))
    assert structural(prepared.weighed, prepared.judged, prepared.base.fit) == more


@pytest.mark.parametrize(("rest", "motion"), [(1.0, True), (-20.0, False)])
def test_a_few_blocks_in_which_both_sensors_show_far_more_make_nobody_less_sure(monkeypatch, rest, motion):
    """What a drag that the other joint pumps showed in ten blocks of 24, and was called `parameters_only` for the spread of its two
    largest; beside blocks in which the sensors show the opposite of each other it might be slow noise."""
    both = np.array([2458.0, 2076.9, 224.9, 172.6, 140.0, 111.0, 61.6, 27.5, 24.0, 15.3, *[rest] * 14])
    assert both.mean() < THROUGHOUT * both.std(ddof=1) / np.sqrt(len(both))
    monkeypatch.setattr("hamr_gap.judging.unexplained.shared", lambda *_: both)
    prepared = prepare(MASS, kicked(0.0, 0.0))
    assert structural(prepared.weighed, prepared.judged, prepared.base.fit) == motion


@pytest.mark.parametrize(("kicks", "verdicts"), [(40.0, {"unknown"}), (2.0, {"parameters_only", "no_significant_gap"})])
def test_where_names_help_a_little_no_gap_beyond_any_noise_is_one_of_parameters(monkeypatch, kicks, verdicts):
    """However seldom it shows: a slew limiter that was hit in a few blocks left 318 times the noise, and was called `parameters_only`."""
    monkeypatch.setattr("hamr_gap.judging.analyse.structural", lambda *_: False)
    monkeypatch.setattr("hamr_gap.judging.analyse._evidence", lambda *_: (10.0, 5.0))
    found = analyse(MASS, kicked(kicks, 0.0))
    assert found.search.best.effects and found.verdict.verdict in verdicts
