"""Least squares with each segment's start eliminated, against the same problem solved whole."""

from __future__ import annotations

import numpy as np
import pytest

from hamr_gap.walking.eliminate import Eliminated

SEGMENTS, READINGS, STARTS, SHARED = 5, 40, 6, 3


@pytest.fixture
def problem():
    random = np.random.default_rng(4)
    slopes = random.normal(size=(SEGMENTS, READINGS, STARTS))
    return slopes, random.normal(size=(SEGMENTS, READINGS, SHARED)), random.normal(size=(SEGMENTS, READINGS))


def whole(slopes, columns, residual, weight):
    """The shared step of the problem with all starts in it."""
    root = np.sqrt(weight)[:, None, None]
    matrix = np.zeros((SEGMENTS, READINGS, SHARED + SEGMENTS * STARTS))
    matrix[..., :SHARED] = columns * root
    for s in range(SEGMENTS):
        at = SHARED + s * STARTS
        matrix[s, :, at : at + STARTS] = slopes[s] * root[s]
    flat = matrix.reshape(-1, matrix.shape[2])
    return np.linalg.lstsq(flat, (residual * root[..., 0]).ravel(), rcond=None)[0][:SHARED]


@pytest.mark.parametrize("blind", [(), (2,), (0, 2, 5), tuple(range(STARTS))])
def test_what_all_share_is_that_of_the_whole_problem(problem, blind):
    """Also where some directions of a start, or all, are not known since their probes diverged."""
    slopes, columns, residual = problem
    slopes[1][:, blind] = 0.0
    weight = np.linspace(0.3, 1.0, SEGMENTS)
    hessian, gradient = Eliminated(slopes).normal(columns, residual, weight)
    np.testing.assert_allclose(np.linalg.solve(hessian, gradient), whole(slopes, columns, residual, weight), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("damping", [0.0, 0.3])
def test_starts_step_where_something_is_known(problem, damping):
    slopes, _, residual = problem
    slopes[1][:, 2] = 0.0
    (steps,) = Eliminated(slopes).starts(residual, [damping])
    assert steps[1, 2] == 0.0
    known = np.delete(slopes[1], 2, axis=1)
    gram = known.T @ known
    expected = np.linalg.solve(gram + damping * np.diag(np.diag(gram)), known.T @ residual[1])
    np.testing.assert_allclose(np.delete(steps[1], 2), expected, rtol=1e-9)
