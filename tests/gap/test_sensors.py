"""Readings through gains, offsets and late clocks, against signals that are known at every time."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from scipy.ndimage import correlate1d

from hamr_gap.fitting.sensors import Sensors, late, slope

STEP = 1e-3
TIME = STEP * np.arange(400)


def waves(time: np.ndarray) -> np.ndarray:
    """(n, 2): 25 Hz and 60 Hz, far below half the rate."""
    return np.column_stack([np.sin(2 * np.pi * 25 * time), np.cos(2 * np.pi * 60 * time)])


@pytest.mark.parametrize("steps", [-2.7, -1.0, -0.3, 0.3, 1.0, 1.5, 3.2])
def test_a_late_clock_reads_what_was_before(steps):
    found = late(waves(TIME), steps * STEP, STEP)
    inside = slice(8, -8)  # nobody knows what was before the first reading or will be after the last
    assert found[inside] == pytest.approx(waves(TIME - steps * STEP)[inside], abs=1e-5)


def test_a_line_is_late_by_the_same_everywhere():
    line = np.column_stack([2.0 * TIME, 1.0 - TIME])
    for shift in (-40.2 * STEP, -2.5 * STEP, 1.3 * STEP, 12.4 * STEP):
        assert late(line, shift, STEP) == pytest.approx(np.column_stack([2.0 * (TIME - shift), 1.0 - TIME + shift]), abs=1e-12)


@pytest.mark.parametrize("whole", [-17, 0, 5])
def test_late_readings_are_those_of_another_library_to_the_bit(whole):
    """No fit takes another way for how sums are rounded."""
    y, ahead = np.random.default_rng(2).normal(size=(400, 2)).cumsum(0), 0.25
    taps = lagrange_weights(np.arange(-3, 4), ahead)
    inside = slice(24, -24)
    expected = np.roll(correlate1d(y, taps, axis=0), whole, axis=0)
    np.testing.assert_array_equal(late(y, whole - ahead, 1.0)[inside], expected[inside])


def lagrange_weights(nodes: np.ndarray, x: float) -> np.ndarray:
    return np.array([np.prod((x - nodes[nodes != node]) / (node - nodes[nodes != node])) for node in nodes])


def test_runs_are_read_each_as_alone():
    runs = np.stack([waves(TIME), 3.0 * waves(TIME + 0.01)])
    sensors = Sensors(bias=np.array([0.1, -0.2]), gain=np.array([0.05, 0.0]), shift=1.4 * STEP)
    alone = np.stack([sensors.read(run, STEP) for run in runs])
    np.testing.assert_array_equal(sensors.read(runs, STEP), alone)
    assert alone[1, 8:-8] == pytest.approx((3.0 * waves(TIME + 0.01 - sensors.shift) * [1.05, 1.0] + [0.1, -0.2])[8:-8], abs=1e-4)


def test_pieces_start_where_they_were_measured_and_know_nothing_of_each_other():
    starts, shift = (0, 150, 151, 300), 0.5 * STEP
    jumping = waves(TIME) + np.repeat([0.0, 7.0, -2.0, 5.0], np.diff([*starts, len(TIME)]))[:, None]
    found = late(jumping, shift, STEP, starts)
    np.testing.assert_array_equal(found[list(starts)], jumping[list(starts)])
    np.testing.assert_allclose(found - jumping, late(waves(TIME), shift, STEP, starts) - waves(TIME), rtol=0, atol=1e-14)
    rates = np.gradient(waves(TIME[151:300]), STEP, axis=0)
    assert (found - jumping)[151:300] == pytest.approx(-shift * (rates - rates[0]), abs=1e-12)
    np.testing.assert_array_equal(late(jumping, shift, STEP, starts[1:])[150:], found[150:])


def test_the_slope_of_a_whole_run_is_its_gradient():
    np.testing.assert_allclose(slope(waves(TIME), STEP), np.gradient(waves(TIME), STEP, axis=0), rtol=1e-12)


@pytest.mark.parametrize("starts", [(), (0,)])
def test_a_run_that_diverges_is_read_without_a_warning(starts):
    y = np.array([[1e308], [-1e308], [1e308], [np.inf]] * 10)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert not np.isfinite(late(y, 0.5, 1.0, starts)).all()
