"""The leg law against its formula, written out here once more joint by joint."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from toy import ToyEngine

from hamr_controller.driver import LocalEnd
from hamr_controller.law import Gains, voltages
from hamr_controller.plan import Plan
from hamr_controller.simulation import Simulation
from hamr_description.names import JOINTS
from hamr_description.numbers import value

GAINS = Gains(kp=(300.0, 200.0), kd=(0.7, 0.9))
angles = arrays(float, 8, elements=st.floats(-0.5, 0.5))
rates = arrays(float, 8, elements=st.floats(-200, 200))


def formula(joint: int, target: float, position: float, velocity: float) -> float:
    """Volts of one joint; every swing and the left lifts push with the voltage, the right lifts against it."""
    name = JOINTS[joint]
    sign = -1.0 if name in ("rl_lift", "rr_lift") else 1.0
    kp, kd = (300.0, 0.7) if name.endswith("swing") else (200.0, 0.9)
    return min(max(112.5 + sign * (kp * (target - position) - kd * velocity), 0.0), 225.0)


@given(target=angles, position=angles, velocity=rates)
def test_volts_are_those_of_the_formula(target, position, velocity):
    out = np.full(8, np.nan)
    voltages(target, position, velocity, GAINS, out)
    expected = [formula(j, target[j], position[j], velocity[j]) for j in range(8)]
    np.testing.assert_allclose(out, expected, rtol=0, atol=1e-11)


def test_at_rest_on_target_the_drives_are_neutral():
    out = np.empty(8)
    voltages(np.full(8, 0.1), np.full(8, 0.1), np.zeros(8), Gains.default(), out)
    assert (out == 112.5).all()


def test_gains_come_from_the_numbers_in_outside_units():
    assert Gains.default() == Gains((value("controller.kp"),) * 2, (value("controller.kd") * 1e-3,) * 2)
    assert Gains.lqr().kp == tuple(value("controller.kp_lqr"))


@given(target=angles, sample=arrays(float, (7, 8), elements=st.floats(-1, 1)), k=st.integers(0, 79))
def test_a_plan_is_the_law_and_its_parts_add_up(target, sample, k):
    tracked, direct, played = np.empty(8), np.empty(8), np.empty(8)
    Plan.track(target, GAINS).answer(k, sample, tracked)
    voltages(target, sample[0], sample[1], GAINS, direct)
    assert (tracked == direct).all()
    feed = np.linspace(-50, 275, 640).reshape(80, 8)
    Plan.open_loop(feed).answer(k, sample, played)
    assert (played == np.clip(feed[k], 0, 225)).all()
    Plan.neutral().answer(k, sample, played)
    assert (played == 112.5).all()


@pytest.mark.parametrize("compiled", [True, False])
def test_a_step_of_ten_degrees_rises_within_a_period_on_the_toy(compiled):
    """The law at 20 kHz really moves the hips where they should go, and the compiled loop is the stepwise one to the bit."""

    class Stepwise:
        """The engine without its compiled loop."""

        def __init__(self):
            self._engine = ToyEngine()

        def __getattr__(self, name):
            if name == "servo_period":
                raise AttributeError(name)
            return getattr(self._engine, name)

    class Hold:
        def plan(self, period):
            return Plan.track(np.full(8, np.deg2rad(10)), Gains.default())

        def done(self, period, volts):
            pass

    ends = []
    for engine in (ToyEngine() if compiled else Stepwise(), ToyEngine()):
        simulation = Simulation(engine, LocalEnd(Hold()), seed=1)
        for _ in range(5):
            assert simulation.measure()
            simulation.offer()
            simulation.end.poll(simulation.volts[0])
            simulation.run()
        ends.append((simulation.samples.copy(), simulation.volts.copy()))
    assert all((a == b).all() for a, b in zip(*ends, strict=True))
    np.testing.assert_allclose(np.rad2deg(ends[0][0][-1, 0]), 10, atol=1.0)
