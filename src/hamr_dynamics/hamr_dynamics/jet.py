"""Second-order jets in a leg's two hip angles: a value with gradient and Hessian, carried through arithmetic.

They give Jacobians and velocity-product accelerations of any closed-form leg, with no derivative written by hand.
"""

from __future__ import annotations

from dataclasses import dataclass

from . import scalar


@dataclass(frozen=True, slots=True)
class Jet:
    """value, gradient (2,), Hessian (11, 12, 22); components may be floats, arrays or traced scalars."""

    value: object
    d: tuple = (0.0, 0.0)
    dd: tuple = (0.0, 0.0, 0.0)

    def __add__(self, other):
        other = lift(other)
        return Jet(self.value + other.value, _plus(self.d, other.d), _plus(self.dd, other.dd))

    def __sub__(self, other):
        return self + -lift(other)

    def __rsub__(self, other):
        return -self + other

    def __neg__(self):
        return Jet(-self.value, tuple(-x for x in self.d), tuple(-x for x in self.dd))

    def __mul__(self, other):
        if not isinstance(other, Jet):
            return Jet(self.value * other, tuple(x * other for x in self.d), tuple(x * other for x in self.dd))
        a, b = self, other
        cross = (2.0 * (a.d[0] * b.d[0]), a.d[0] * b.d[1] + a.d[1] * b.d[0], 2.0 * (a.d[1] * b.d[1]))
        return Jet(
            a.value * b.value,
            tuple(a.value * y + x * b.value for x, y in zip(a.d, b.d, strict=True)),
            tuple(a.value * y + x * b.value + z for x, y, z in zip(a.dd, b.dd, cross, strict=True)),
        )

    __radd__ = __add__
    __rmul__ = __mul__

    def __truediv__(self, other):
        return self * reciprocal(other) if isinstance(other, Jet) else self * (1.0 / other)

    def rate(self, v):
        """Time derivative at hip rates v (2,)."""
        return self.d[0] * v[0] + self.d[1] * v[1]

    def bias(self, v):
        """Second time derivative at hip rates v and zero hip acceleration."""
        return self.dd[0] * (v[0] * v[0]) + 2.0 * (self.dd[1] * (v[0] * v[1])) + self.dd[2] * (v[1] * v[1])


def _plus(a, b):
    return tuple(x + y for x, y in zip(a, b, strict=True))


def lift(x) -> Jet:
    """A constant as a jet."""
    return x if isinstance(x, Jet) else Jet(x)


def chain(x: Jet, f, f1, f2) -> Jet:
    """A function of a jet from its value and two derivatives there."""
    d = x.d
    square = (d[0] * d[0], d[0] * d[1], d[1] * d[1])
    return Jet(f, tuple(f1 * y for y in d), tuple(f1 * y + f2 * z for y, z in zip(x.dd, square, strict=True)))


def reciprocal(x: Jet) -> Jet:
    """1/x."""
    r = 1.0 / x.value
    r2 = r * r
    return chain(x, r, -r2, 2.0 * (r2 * r))


def sqrt(x: Jet) -> Jet:
    """Square root."""
    root = scalar.sqrt(x.value)
    r = 0.5 / root
    return chain(x, root, r, -r / (2.0 * x.value))


def sincos(x: Jet) -> tuple[Jet, Jet]:
    """Sine and cosine."""
    s, c = scalar.sin(x.value), scalar.cos(x.value)
    return chain(x, s, c, -s), chain(x, c, -s, -c)


def angle(s: Jet, c: Jet) -> Jet:
    """Angle with sine s and cosine c, with exact derivatives: d(angle) = c ds - s dc."""
    d = tuple(c.value * y - s.value * x for x, y in zip(c.d, s.d, strict=True))
    pairs = ((0, 0), (0, 1), (1, 1))
    dd = tuple(
        c.value * s.dd[k] - s.value * c.dd[k] + (c.d[j] * s.d[i] - s.d[j] * c.d[i]) for k, (i, j) in enumerate(pairs)
    )
    return Jet(scalar.angle(s.value, c.value), d, dd)


def variables(q) -> tuple[Jet, Jet]:
    """The two hip angles (swing, lift) as jets."""
    return Jet(q[0], (1.0, 0.0)), Jet(q[1], (0.0, 1.0))
