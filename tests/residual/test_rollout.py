"""Derivatives through whole roll-outs equal finite differences, for the series law and for torch networks."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from residual_samples import noise_run, recording

from hamr_dynamics.leg_step import LANES, LegStep
from hamr_sim_residual import dataset, fit_mlp
from hamr_sim_residual.fit_series import warm_start
from hamr_sim_residual.mlp import Mlp
from hamr_sim_residual.residual_plant import torque_driven
from hamr_sim_residual.rollout import FREE, Rollout
from hamr_sim_residual.series import LIMITS, Series


@pytest.fixture(scope="module")
def parts():
    return dataset.stretches(recording(noise_run(0, 0.6)))


@pytest.fixture(scope="module")
def rolled(parts):
    law = Series(3)
    windows = dataset.windows(parts, 40, LegStep(torque_driven()))[:1]
    weights = warm_start(law, parts)
    roll = Rollout(law, stride=1)
    return roll, windows, weights, roll(windows, windows.state0, weights, slopes="all")


def test_slopes_by_weights_equal_finite_differences(rolled):
    roll, windows, weights, (_, slopes) = rolled
    random = np.random.default_rng(0)
    direction = random.standard_normal(len(weights)) * np.abs(weights)
    direction[: len(LIMITS)] = 0.0
    difference = _central(lambda x: roll(windows, windows.state0, weights + x * direction)[0], 1e-4)
    predicted = (slopes[:, :, FREE:] @ direction).reshape(difference.shape)
    assert _relative(difference, predicted) < 1e-7


@pytest.mark.parametrize("row", range(FREE))
def test_slopes_by_initial_state_equal_finite_differences(rolled, row):
    roll, windows, weights, (_, slopes) = rolled
    shift = np.zeros((1, 6, LANES))
    shift[:, row] = 1.0
    difference = _central(lambda x: roll(windows, windows.state0 + x * shift.reshape(1, -1), weights)[0], 1e-5)
    assert _relative(difference, slopes[:, :, row].reshape(difference.shape)) < 1e-7


def _central(errors, size: float) -> np.ndarray:
    """Derivative of the roll-out's angles (errors are measured minus rolled out)."""
    return (errors(-size) - errors(size)) / (2 * size)


def _relative(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.abs(a - b).max() / np.abs(b).max())


@pytest.mark.parametrize("scope", ["leg", "robot"])
def test_gradient_of_a_torch_roll_out_equals_finite_differences(parts, scope, monkeypatch):
    for module in (fit_mlp, fit_mlp.surrogate):
        monkeypatch.setattr(module, "TYPE", torch.float64)
    monkeypatch.setattr("hamr_sim_residual.perceptron.TYPE", torch.float64)
    trainer = fit_mlp.Trainer(parts, Mlp(scope, (5,)), "step", seed=0)
    trainer.steps = 30
    weights = trainer.net.initial(np.random.default_rng(1)).requires_grad_()
    chosen = trainer.data.starts[[10, 500]]
    (gradient,) = torch.autograd.grad(trainer.multi_step(weights, chosen), weights)
    direction = torch.from_numpy(np.random.default_rng(2).standard_normal(len(weights)))
    with torch.no_grad():
        ends = [trainer.multi_step(weights + s * 1e-5 * direction, chosen).item() for s in (1, -1)]
    assert (ends[0] - ends[1]) / 2e-5 == pytest.approx(float(gradient @ direction), rel=1e-6)
