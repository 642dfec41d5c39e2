"""What readings say: less where they are correlated, nothing where they are sent again."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter
from shaken_leg import STEP

from hamr_gap.data.readings import fresh, noise_of
from hamr_gap.data.record import Record
from hamr_gap.judging.colour import correlation_time


@given(st.floats(0.0, 0.9))
def test_correlated_readings_count_less(share):
    """Of a first-order process, (1 + a) / (1 - a) readings say what one independent reading would."""
    x = lfilter([1.0], [1.0, -share], np.random.default_rng(0).standard_normal((40_000, 2)), axis=0)
    assert correlation_time(x) == pytest.approx((1 + share) / (1 - share), rel=0.15)


@pytest.mark.parametrize("motion", [0.0, 100.0])
def test_noise_is_what_it_is_on_average(motion):
    """Beside a smooth motion too: estimated from 2000 samples, 200 times."""
    rng = np.random.default_rng(1)
    smooth = motion * np.sin(np.linspace(0.0, 60.0, 2000))[:, None]
    squares = [noise_of(smooth + rng.standard_normal((2000, 1)))[0] ** 2 for _ in range(200)]
    assert np.mean(squares) == pytest.approx(1.0, abs=0.02)  # the mean is known to 0.005


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
