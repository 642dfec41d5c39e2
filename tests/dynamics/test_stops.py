"""End stops never pull; at full voltage and any frequency the legs stay within them and every state stays finite."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hamr_description.numbers import value
from hamr_dynamics.batch import SIGN, BatchSim
from hamr_dynamics.stops import stop_force
from hamr_sim_full import transmission
from hamr_sim_full.parameters import leg_parameters

STOP = value("actuator.stop")
LAW = {"stiffness": value("actuator.stop_stiffness"), "damping": value("actuator.stop_damping")}
finite = {"allow_nan": False, "allow_infinity": False}


@given(st.floats(-2, 2, **finite), st.floats(-5, 5, **finite))
def test_a_stop_never_pulls(x, rate):
    stop = stop_force(x, rate, -STOP, STOP, **LAW)
    force = float(stop.force)
    assert force * x <= 0.0
    if abs(x) <= STOP:
        assert force == 0.0
        assert float(stop.active) == 0.0
    assert (float(stop.active) == 1.0) == (force != 0.0)


@given(st.floats(0, 1, **finite), st.floats(-0.3, 0.3, **finite))
def test_a_stop_is_a_spring_and_damper_while_pressed(depth, rate):
    stop = stop_force(STOP + depth, rate, -STOP, STOP, **LAW)
    pressed = (STOP + depth) - STOP  # as the law sees it: a depth below rounding is none
    push = max(LAW["stiffness"] * pressed + LAW["damping"] * rate, 0.0) * (pressed > 0)
    assert float(stop.force) == pytest.approx(-push, abs=1e-12)


@given(st.integers(-400, 399).map(lambda k: (k + 0.5) * 1e-4), st.floats(-30, 30, **finite), st.sampled_from([-1.0, 1.0]))
def test_a_stop_that_knows_the_step_pushes_for_the_part_in_which_it_touches(depth, rate, side):
    """Spring and damper are the means over a step at a steady rate; so no run jumps with the step in which it hits."""
    step, along = 1e-3, depth + rate * 1e-3 * ((np.arange(1000) + 0.5) / 1000 - 0.5)
    spring, damper = ({"stiffness": 5.0, "damping": 1e-9}, {"stiffness": 1e-9, "damping": 2.0})
    push = stop_force(side * (STOP + depth), side * rate, -STOP, STOP, **spring, step=step)
    assert -side * float(push.force) == pytest.approx(5.0 * np.mean(np.maximum(along, 0.0)), abs=1e-5)
    if rate > 0.0:
        assert float(stop_force(side * (STOP + depth), side * rate, -STOP, STOP, **damper, step=step).damping) == pytest.approx(
            2.0 * np.mean(along > 0.0), abs=3e-3
        )


@given(st.floats(-2, 2, **finite), st.floats(-5, 5, **finite), st.floats(0.01, 0.5, **finite))
def test_a_stop_that_knows_the_step_never_pulls(x, rate, step):
    stop = stop_force(x, rate, -STOP, STOP, **LAW, step=step)
    reach = 0.5 * step * abs(rate)
    if x - reach > -STOP:
        assert stop.force <= 0.0
    if x + reach < STOP:
        assert stop.force >= 0.0
    assert (float(stop.active) == 1.0) == (stop.force != 0.0)


HALVES = np.unique(np.round(np.geomspace(5, 100, 12)).astype(int))  # half periods in units of 0.5 ms: 200 to 10 Hz
PATTERNS = np.array([
    [1, 1, 1, 1, 1, 1, 1, 1],
    [1, -1, 1, -1, 1, -1, 1, -1],
    [1, 1, -1, -1, -1, -1, 1, 1],
    [1, -1, -1, 1, -1, 1, 1, -1],
])  # fmt: skip
SECONDS = 10.0


@pytest.mark.parametrize("backend", ["simple", "full"])
@pytest.mark.parametrize("environment", ["suspended", "ground"])
def test_full_voltage_square_waves_leave_the_state_finite(backend, environment):
    """10 s of 10 to 200 Hz on all eight actuators, in and out of phase: finite, within the stops, and the stops do work."""
    half, pattern = (x.ravel() for x in np.meshgrid(HALVES, np.arange(len(PATTERNS)), indexing="ij"))
    sim = BatchSim(backend, len(half), environment=environment)
    sim.set_gains(1e6, 0.0)  # the law saturates at once: full voltage of the target's sign
    ticks = round(SECONDS * 2000)
    largest = np.zeros(8)
    for k in range(ticks):
        up = np.where((k // half) % 2 == 0, 10.0, -10.0)
        sim.step_targets(up[:, None] * PATTERNS[pattern], steps=10)
        if k % 50 == 0:
            largest = np.maximum(largest, np.abs(sim.q).max(axis=0))
    assert sim.finite.all()
    assert np.isfinite(sim.qd).all()
    assert sim.counts.sum() > 0
    assert largest.max() < 0.85, "rad; the swing stop lies at 0.67"


def test_sliders_overshoot_their_stops_by_little():
    """HAMR-full at its modes, where a square wave is strongest: tips within 0.05 mm of the stops, clear of the dead centre at 0.53 mm."""
    hz = np.array([70.0, 80.0, 85.0, 90.0, 100.0, 110.0, 122.0, 130.0])
    sim = BatchSim("full", len(hz), environment="suspended")
    t = np.arange(8000) * 0.05
    wave = np.where(np.sin(2 * np.pi * hz[:, None] * t / 1e3) >= 0, 225.0, 0.0)
    record = sim.step_voltages(np.repeat(wave[:, :, None], 8, axis=2), record=True)
    q = (record["q"] * SIGN)[:, :, :2].reshape(-1, 2)
    tips = [tip.value for tip in transmission.solve((q[:, 0], q[:, 1]), leg_parameters("fl")).tips]
    overshoot = max(np.abs(tip).max() for tip in tips) - STOP
    assert 0.0 < overshoot < 0.05
