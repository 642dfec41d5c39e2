"""Functions of one scalar that work on floats, numpy arrays and traced scalars alike.

Sine, cosine and arctangent are polynomials, so that compiled lanes stay vectors (library calls would not).
"""

from __future__ import annotations

import math

import numpy as np

from .trace import Var

LITTLE = 1e-30  # beside a divisor that may be zero


def sqrt(x):
    """Square root."""
    return x.graph.record("sqrt", x) if isinstance(x, Var) else np.sqrt(x)


def maximum(a, b):
    """Larger of two."""
    graph = _graph(a, b)
    return graph.record("max", a, b) if graph else np.maximum(a, b)


def minimum(a, b):
    """Smaller of two."""
    graph = _graph(a, b)
    return graph.record("min", a, b) if graph else np.minimum(a, b)


def positive(x):
    """1 where x > 0, else 0: the gate of unilateral forces."""
    return x.graph.record("positive", x) if isinstance(x, Var) else np.where(np.asarray(x) > 0, 1.0, 0.0)


def floor(x):
    """Largest whole number not above x, its real part in a complex step."""
    return x.graph.record("floor", x) if isinstance(x, Var) else np.floor(np.real(x))


def clip(x, low, high):
    """x limited to low..high."""
    return minimum(maximum(x, low), high)


def _graph(*operands):
    return next((x.graph for x in operands if isinstance(x, Var)), None)


def _horner(coefficients, x):
    total = coefficients[-1]
    for c in reversed(coefficients[:-1]):
        total = total * x + c
    return total


_SIN = [(-1) ** k / math.factorial(2 * k + 1) for k in range(11)]
_COS = [(-1) ** k / math.factorial(2 * k) for k in range(12)]


def _turned(x):
    """An angle less whole turns, within +-pi; exactly x itself where it is there."""
    return x - 2.0 * math.pi * floor(x * (0.5 / math.pi) + 0.5)


def sin(x):
    """Sine: Taylor polynomial of degree 21, 1e-16 over +-pi/2, 1e-11 elsewhere."""
    x = _turned(x)
    return x * _horner(_SIN, x * x)


def cos(x):
    """Cosine: Taylor polynomial of degree 22, 1e-16 over +-pi/2, 2e-12 elsewhere."""
    x = _turned(x)
    return _horner(_COS, x * x)


def _atan_coefficients() -> list[float]:
    """atan(x)/x as a polynomial of x^2 on [0, tan(pi/8)^2], interpolated at Chebyshev nodes to 1e-16."""
    top = math.tan(math.pi / 8) ** 2
    node = np.polynomial.chebyshev.Chebyshev.interpolate(lambda y: np.arctan(np.sqrt(y)) / np.sqrt(y), 11, domain=[0.0, top])
    return [float(c) for c in node.convert(kind=np.polynomial.Polynomial, domain=[-1, 1], window=[-1, 1]).coef]


_ATAN = _atan_coefficients()


def angle(s, c):
    """Angle with sine s and cosine c (s^2 + c^2 = 1): 5e-15 over +-pi/2, by two half-angle steps and a polynomial."""
    t = s / (1.0 + c)
    t = t / (1.0 + sqrt(1.0 + t * t))
    return 4.0 * t * _horner(_ATAN, t * t)
