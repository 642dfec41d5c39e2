"""Sensors with coarse steps, found in a residual: against staircases made here, and silence where there is none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from hamr_gap.data.record import Record
from hamr_gap.fitting.model import Model
from hamr_gap.fitting.scales import scales_of
from hamr_gap.fitting.sensors import late
from hamr_gap.legs import machine_of
from hamr_gap.naming.prepare import prepare
from hamr_gap.naming.search import with_steps
from hamr_gap.naming.staircase import staircase
from hamr_gap.naming.tried import Search

TIME = np.arange(24000) / 4000.0
ANGLE = 0.15 * np.sin(2 * np.pi * 13.0 * TIME) + 0.08 * np.sin(2 * np.pi * 29.3 * TIME + 1.0)
NOISE = np.random.default_rng(0).standard_normal(len(TIME))


@given(st.floats(0.004, 0.04), st.floats(-0.5, 0.5))
def test_step_and_offset_are_found(step, share):
    offset = share * step
    read = step * np.floor((ANGLE - offset) / step + 0.5) + offset
    seen = staircase(ANGLE, read - ANGLE + 1e-3 * NOISE)
    assert seen.step == pytest.approx(step, rel=3e-3)
    wrong = (seen.offset - offset + 0.5 * step) % step - 0.5 * step
    assert abs(wrong) < 0.05 * step


@settings(max_examples=30)
@given(st.floats(0.006, 0.03), st.floats(-0.5, 0.5), st.floats(0.1, 0.45))
def test_a_counter_that_moves_on_late_is_found(step, share, stick):
    """Also one that is a quarter of a step late, whose sawteeth up and down cancel each other; sampled at 20 kHz, as counters are."""
    time = np.arange(48000) / 20000.0
    angle = 0.15 * np.sin(2 * np.pi * 13.0 * time) + 0.08 * np.sin(2 * np.pi * 29.3 * time + 1.0)
    offset, now, read = share * step, 0.0, []
    for x in ((angle - offset) / step).tolist():
        if abs(x - now) > 0.5 + stick:
            now = round(x)
        read.append(now)
    seen = staircase(angle, step * np.array(read) + offset - angle + 1e-3 * np.tile(NOISE, 2))
    assert seen.step == pytest.approx(step, rel=5e-3)
    assert seen.stick == pytest.approx(stick, abs=0.03)
    wrong = (seen.offset - offset + 0.5 * step) % step - 0.5 * step
    assert abs(wrong) < 0.08 * step


@pytest.mark.parametrize("left", [1e-3 * NOISE, 0.3 * ANGLE**3, 2e-3 * np.sign(ANGLE), 1e-3 * np.sin(2 * np.pi * ANGLE / 0.03)])
def test_noise_and_laws_of_the_angle_are_no_steps(left):
    """The last has the period of a staircase, but not its height."""
    assert staircase(ANGLE, left + 1e-4 * NOISE) is None


@given(st.floats(-3.0, 3.0))
@example(0.9e-3)  # the largest that is taken to first order, and what once was
@example(0.0078)
def test_a_late_reading_is_the_signal_late(shift):
    y = np.stack([ANGLE, np.cos(2 * np.pi * 40.0 * TIME)], 1)[::4]
    exact = np.stack([
        0.15 * np.sin(2 * np.pi * 13.0 * (TIME - shift * 1e-3)) + 0.08 * np.sin(2 * np.pi * 29.3 * (TIME - shift * 1e-3) + 1.0),
        np.cos(2 * np.pi * 40.0 * (TIME - shift * 1e-3)),
    ], 1)[::4]  # fmt: skip
    assert np.abs(late(y, shift * 1e-3, 1e-3) - exact)[10:-10].max() < 1e-5


def test_steps_show_beside_the_model_as_it_is_where_no_effect_fits():
    """A counter of a ninth of the travel: all that else was tried may hide it."""
    leg, time = machine_of("simple", "fl"), np.arange(16000) * 0.25
    drives = 40.0 * np.stack([np.sin(time * (0.05 + 0.03 * np.sin(time * p))) for p in (1e-3, 1.3e-3)], 1)
    still = Record(drives, np.tile(np.sin(time)[:, None], len(leg.channels)), 0.25, leg.channels)
    readings = Model(leg, still, 2, 1, scales_of(leg, still)).plain + 1e-3 * np.random.default_rng(0).standard_normal(still.readings.shape)
    swing = readings[:, 0].copy()
    readings[:, 0] = np.ptp(swing) / 9.0 * np.round(swing / np.ptp(swing) * 9.0) + 1e-3 * NOISE[:16000]
    prepared = prepare(leg, replace(still, readings=readings))
    state = Search(prepared.weighed, prepared.base, None, int(prepared.judged.sum()))
    with_steps(prepared.weighed, prepared.judged, state, lambda _: None)
    assert state.best.names == {("sensor_quantisation", (0,))}
    assert state.best.left - 1.0 < 0.1 * (prepared.base.left - 1.0)
