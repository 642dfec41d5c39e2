"""The residual backend: one-robot and many-robot kernels agree, plain HAMR-simple is a special case, nothing makes it diverge."""

from __future__ import annotations

import numpy as np
import pytest

from hamr_description.numbers import value
from hamr_dynamics.batch import BatchSim
from hamr_sim_residual.fit_series import limits, prior
from hamr_sim_residual.network import Network
from hamr_sim_residual.residual_plant import torque_driven
from hamr_sim_residual.series import Series

NEUTRAL = value("actuator.neutral_voltage")


def gait(n: int, seed: int = 0) -> np.ndarray:
    """(n, 8) targets."""
    return np.random.default_rng(seed).uniform(-0.3, 0.3, (n, 8))


def test_many_robots_equal_one_on_the_ground():
    many, one = BatchSim("residual", 16), BatchSim("residual", 1)
    for target in gait(3):
        many.step_targets(np.tile(target, (16, 1)))
        one.step_targets(target[None])
    for name in ("q", "qd", "position", "velocity", "quaternion", "angular_velocity"):
        np.testing.assert_allclose(getattr(many, name), np.tile(getattr(one, name), (16, 1)), rtol=0, atol=1e-12, err_msg=name)


def test_prior_mean_is_plain_simple():
    law = Series(3)
    plain = torque_driven(Network(law, np.concatenate([limits(), prior(law).mean])))
    runs = [BatchSim(plant, 1, environment="suspended", block=16) for plant in (plain, "simple")]
    volts = NEUTRAL + 60 * np.random.default_rng(2).uniform(-1, 1, (1, 400, 8))
    for sim in runs:
        sim.step_voltages(volts)
    np.testing.assert_allclose(runs[0].q, runs[1].q, rtol=0, atol=1e-12)


def test_single_precision_follows_double():
    runs = [BatchSim("residual", 32, environment="suspended", dtype=dtype) for dtype in (np.float32, np.float64)]
    volts = NEUTRAL + 60 * np.random.default_rng(3).uniform(-1, 1, (32, 400, 8))
    for sim in runs:
        sim.step_voltages(volts)
    assert np.abs(runs[0].q - runs[1].q).max() < 1e-4 * np.abs(runs[1].q).max()


@pytest.mark.parametrize("hertz", [10, 100, 200])
def test_square_waves_at_full_voltage_stay_finite(hertz):
    sim = BatchSim("residual", 16)
    wave = np.sign(np.sin(2 * np.pi * hertz * np.arange(8000) / 20_000))
    phase = np.random.default_rng(hertz).choice([-1, 1], (16, 1, 8))
    sim.step_voltages(NEUTRAL * (1 + phase * wave[None, :, None]))
    assert sim.finite.all()
    assert np.abs(sim.q).max() < 1.2
