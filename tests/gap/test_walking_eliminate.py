"""Least squares with each segment's start eliminated, against the same problem solved whole."""

from __future__ import annotations

import numpy as np
import pytest

from hamr_gap.walking.eliminate import STEEP, Eliminated

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


@pytest.mark.parametrize("size", [0.9 * STEEP, 1e10, 1e100, 1e200])
@pytest.mark.parametrize("alike", [(0, 3), (0, 3, 4)])
def test_probes_on_their_way_to_diverge_leave_nothing_singular(size, alike):
    """Directions alike have their priors alone to tell them apart, which the squares of senseless slopes would swallow."""
    random = np.random.default_rng(6)
    slopes = np.concatenate([random.normal(size=(1, 600, STARTS)), np.eye(STARTS)[None]], axis=1)
    slopes[0, :600, alike] = size * random.uniform(-1.0, 1.0, 600)
    residual = random.normal(size=(1, 600 + STARTS))
    linear = Eliminated(slopes)
    (steps,) = linear.starts(residual, [0.0])
    hessian, gradient = linear.normal(random.normal(size=(1, 600 + STARTS, SHARED)), residual, np.ones(1))
    assert np.linalg.eigvalsh(hessian).min() > 0.0
    assert np.isfinite(gradient).all()
    if size > STEEP:
        np.testing.assert_array_equal(steps[0, alike], 0.0)
    others = np.delete(np.arange(STARTS), alike)
    assert np.all(steps[0, others] != 0.0)
