"""Derivatives of the compiled step against complex steps and differences through the plain functions."""

from __future__ import annotations

import numpy as np
import pytest

from hamr_description.rates import SERVO_MS
from hamr_dynamics.leg_step import STATE, LegStep
from hamr_dynamics.plant import flatten, plant, unflatten
from hamr_dynamics.step import LegState, step_suspended

LANES = 21  # more than a block, not a multiple of one
BACKENDS = ("simple", "full")
TINY = 1e-30


def inputs(step: LegStep, rng):
    """Random states within the stops, drives and parameters within a tenth of the real ones."""
    state = np.vstack([rng.uniform(-0.4, 0.4, (2, LANES)), rng.normal(0, 0.1, (2, LANES)), rng.normal(0, 0.05, (2, LANES))])
    param = step.parameters("fl", gravity=9.81e-3)[:, None] * rng.uniform(0.9, 1.1, (len(step.parameter_names), LANES))
    return state, rng.uniform(-100, 100, (2, LANES)), param


def plain(step: LegStep, state, drive, param) -> np.ndarray:
    """(6, lanes) next state by the functions themselves, over real or complex numbers."""
    like = step.plant.parameters("fl")
    flat = flatten(like) | dict(zip(step.parameter_names, param, strict=True))
    args = LegState(*(tuple(state[i : i + 2]) for i in (0, 2, 4)))
    new, _ = step_suspended(step.plant.leg, args, tuple(drive), unflatten(flat, like), flat["gravity"], SERVO_MS)
    return np.array([*new.q, *new.v, *new.a])


@pytest.mark.parametrize("backend", BACKENDS)
def test_compiled_step_is_the_function(backend, rng):
    step = LegStep(plant(backend))
    state, drive, param = inputs(step, rng)
    assert step.step(state, drive, param) == pytest.approx(plain(step, state, drive, param), rel=1e-11, abs=1e-13)


@pytest.mark.parametrize("backend", BACKENDS)
def test_pullback_is_the_derivative(backend, rng):
    """Every state, drive and parameter by complex step: to rounding, no matter how unlike their sizes are."""
    step = LegStep(plant(backend))
    arrays = inputs(step, rng)
    grad = rng.normal(size=(len(STATE), LANES))
    found = step.pullback(*arrays, grad)
    for which, (array, gradient) in enumerate(zip(arrays, found, strict=True)):
        for row in range(len(array)):
            moved = [x.astype(complex) for x in arrays]
            moved[which][row] += 1j * TINY
            truth = (plain(step, *moved) * grad).imag.sum(axis=0) / TINY
            assert gradient[row] == pytest.approx(truth, rel=1e-8, abs=1e-10 * max(1.0, np.abs(truth).max())), (which, row)


@pytest.mark.parametrize("backend", BACKENDS)
def test_pullback_in_the_stops_is_the_derivative(backend, rng):
    """Where a stop pushes, by differences: the gates of the stops do not hide its spring and damper."""
    step = LegStep(plant(backend))
    state, drive, param = inputs(step, rng)
    state[:2] = rng.choice([-1.0, 1.0], (2, LANES)) * rng.uniform(0.75, 0.8, (2, LANES))
    grad = rng.normal(size=(len(STATE), LANES))
    gradient, _, _ = step.pullback(state, drive, param, grad)
    for row in range(4):
        h = 1e-6
        there, back = (plain(step, state + side * h * np.eye(len(STATE))[:, row : row + 1], drive, param) for side in (1, -1))
        truth = ((there - back) * grad).sum(axis=0) / (2 * h)
        assert gradient[row] == pytest.approx(truth, rel=1e-4, abs=1e-5 * np.abs(truth).max())


def test_a_trajectory_pulled_back_is_its_gradient(rng):
    """Twenty steps forward and back: the gradient of a final angle with respect to an initial one."""
    step = LegStep(plant("simple"))
    state, drive, param = inputs(step, rng)

    def final(start):
        states = [start]
        for _ in range(20):
            states.append(step.step(states[-1], drive, param))
        return states

    grad = np.zeros_like(state)
    grad[0] = 1.0
    for at in reversed(final(state)[:-1]):
        grad, _, _ = step.pullback(at, drive, param, grad)
    h = 1e-6
    move = h * np.eye(len(STATE))[:, 2:3]
    truth = (final(state + move)[-1][0] - final(state - move)[-1][0]) / (2 * h)
    assert grad[2] == pytest.approx(truth, rel=1e-6)
