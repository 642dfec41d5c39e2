"""Accuracy of the polynomial functions, and jets against differences and the mathematics they stand for."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hamr_dynamics import jet, scalar

ANGLES = np.linspace(-math.pi / 2, math.pi / 2, 20001)
small = st.floats(-0.6, 0.6)


def test_sine_and_cosine_to_the_last_digit():
    assert np.abs(scalar.sin(ANGLES) - np.sin(ANGLES)).max() < 3e-16
    assert np.abs(scalar.cos(ANGLES) - np.cos(ANGLES)).max() < 3e-16


def test_sine_and_cosine_stay_bounded_beyond_their_range():
    """A leg thrown past its stops for a moment meets no huge numbers."""
    far = np.linspace(-math.pi, math.pi, 2001)
    assert np.abs(scalar.sin(far) - np.sin(far)).max() < 1e-10
    assert np.abs(scalar.cos(far) - np.cos(far)).max() < 1e-10


def test_sine_and_cosine_of_any_angle():
    """Of machines of others: a wheel turns on and on."""
    far = np.linspace(-1e3, 1e3, 20001)
    assert np.abs(scalar.sin(far) - np.sin(far)).max() < 2e-11
    assert np.abs(scalar.cos(far) - np.cos(far)).max() < 2e-11


def test_angle_is_the_arctangent():
    assert np.abs(scalar.angle(np.sin(ANGLES), np.cos(ANGLES)) - ANGLES).max() < 5e-15


@given(small, small)
def test_clip_gates_and_limits(x, limit):
    low, high = sorted((limit, 0.3))
    assert scalar.clip(x, low, high) == min(max(x, low), high)
    assert scalar.positive(x) == (x > 0)


def mixture(a, b):
    """An expression of two jets that passes through every rule."""
    (s, c), (u, w) = jet.sincos(a), jet.sincos(b)
    root = jet.sqrt(2.0 + s * u)
    return jet.angle(s * w, jet.sqrt(1.0 - s * s * (w * w))) * root - c / (3.0 + u) * 0.5


def plain(a, b):
    """The same by the standard library."""
    return math.asin(math.sin(a) * math.cos(b)) * math.sqrt(2 + math.sin(a) * math.sin(b)) - math.cos(a) / (3 + math.sin(b)) * 0.5


@given(small, small)
def test_jets_are_value_gradient_and_hessian(a, b):
    x = mixture(*jet.variables((a, b)))
    assert x.value == pytest.approx(plain(a, b), rel=1e-13, abs=1e-14)
    h = 1e-4
    gradient = [(plain(a + h, b) - plain(a - h, b)) / (2 * h), (plain(a, b + h) - plain(a, b - h)) / (2 * h)]
    assert [float(d) for d in x.d] == pytest.approx(gradient, abs=1e-7)
    corner = (plain(a + h, b + h) - plain(a + h, b - h) - plain(a - h, b + h) + plain(a - h, b - h)) / (4 * h * h)
    middle = plain(a, b)
    second = [(plain(a + h, b) - 2 * middle + plain(a - h, b)) / h**2, corner, (plain(a, b + h) - 2 * middle + plain(a, b - h)) / h**2]
    assert [float(d) for d in x.dd] == pytest.approx(second, abs=1e-6)


@given(small, small, st.floats(-1, 1), st.floats(-1, 1))
def test_rate_and_bias_are_time_derivatives(a, b, v, w):
    x, h = mixture(*jet.variables((a, b))), 1e-4
    along = [plain(a + v * t, b + w * t) for t in (-h, 0.0, h)]
    assert float(x.rate((v, w))) == pytest.approx((along[2] - along[0]) / (2 * h), abs=1e-6)
    assert float(x.bias((v, w))) == pytest.approx((along[2] - 2 * along[1] + along[0]) / h**2, abs=1e-5)
