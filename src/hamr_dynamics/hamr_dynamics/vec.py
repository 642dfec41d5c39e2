"""Vectors of three and symmetric 3 x 3 tensors as plain tuples of scalars (floats, arrays or traced)."""

from __future__ import annotations


def add(a, b):
    """a + b."""
    return tuple(x + y for x, y in zip(a, b, strict=True))


def sub(a, b):
    """a - b."""
    return tuple(x - y for x, y in zip(a, b, strict=True))


def scale(a, s):
    """s a."""
    return tuple(x * s for x in a)


def dot(a, b):
    """a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    """a x b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def apply(tensor, v):
    """Symmetric tensor (xx, yy, zz, xy, xz, yz) times vector."""
    xx, yy, zz, xy, xz, yz = tensor
    return (xx * v[0] + xy * v[1] + xz * v[2], xy * v[0] + yy * v[1] + yz * v[2], xz * v[0] + yz * v[1] + zz * v[2])


def rotate(rotation, v):
    """Matrix (three rows) times vector."""
    return tuple(dot(row, v) for row in rotation)


def rotate_tensor(rotation, tensor):
    """R T R^T of a symmetric tensor."""
    columns = [rotate(rotation, column) for column in _columns(tensor)]  # R T, by columns
    rows = [tuple(c[i] for c in columns) for i in range(3)]
    return tuple(dot(rows[i], rotation[j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))


def _columns(tensor):
    xx, yy, zz, xy, xz, yz = tensor
    return (xx, xy, xz), (xy, yy, yz), (xz, yz, zz)


def point_inertia(mass, p):
    """Inertia tensor of a point mass at p about the origin."""
    x, y, z = p
    mx, my, mz = mass * x, mass * y, mass * z
    return (my * y + mz * z, mx * x + mz * z, mx * x + my * y, -(mx * y), -(mx * z), -(my * z))
