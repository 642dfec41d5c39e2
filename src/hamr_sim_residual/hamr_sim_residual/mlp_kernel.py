"""A tanh network as numba source: the fastest order of loops found for few inputs, many lanes and no BLAS call.

Lanes go by in tiles that the first-level cache holds. A layer adds 4 inputs to 4 outputs at a time over a tile, so that 16
weights serve a whole tile and every load feeds several multiply-adds (axpy order, 4 x 4). A block of few lanes (the one-robot
kernel) runs the same arithmetic with vectors along the outputs instead. Sizes are padded to multiples of 4 with zero weights.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

BLOCK = 4
TILE = 64  # lanes
NARROW = 8  # at most so many lanes go one by one

# u = exp(2 x) - 1 from a Taylor polynomial at 2 x / 2^DOUBLINGS, doubled by u <- u (u + 2); then tanh(x) = u / (u + 2).
# Absolute error 2e-15 in float64, 2e-7 in float32; numpy's tanh would not become vector code here.
TERMS, DOUBLINGS, FLAT = 9, 8, 19.0

HEAD = """

@jit
def tanh(x):
    y = (x if x < real({flat}) else real({flat})) if x > real(-{flat}) else real(-{flat})
    y = y * real({scale!r})
    u = y * ({series})
{doublings}
    return u / (u + real(2.0))
"""

TILED = """

@jit
def dense(x, out, weights, at, n_in, n_out, fresh):
    '''out (n_out, {tile}) = bias + W x, or out + W x; weights[at:] hold n_out biases, then W^T (n_in, n_out).'''
    for j in range(0, n_out, 4):
        o0, o1, o2, o3 = U(j * {tile}), U((j + 1) * {tile}), U((j + 2) * {tile}), U((j + 3) * {tile})
        if fresh:
            a0, a1, a2, a3 = weights[at + j], weights[at + j + 1], weights[at + j + 2], weights[at + j + 3]
            for i in range({tile}):
                e = U(i)
                out[o0 + e] = a0
                out[o1 + e] = a1
                out[o2 + e] = a2
                out[o3 + e] = a3
        for k in range(0, n_in, 4):
            w = at + n_out * (k + 1) + j
            a0, b0, c0, d0 = weights[w], weights[w + 1], weights[w + 2], weights[w + 3]
            w += n_out
            a1, b1, c1, d1 = weights[w], weights[w + 1], weights[w + 2], weights[w + 3]
            w += n_out
            a2, b2, c2, d2 = weights[w], weights[w + 1], weights[w + 2], weights[w + 3]
            w += n_out
            a3, b3, c3, d3 = weights[w], weights[w + 1], weights[w + 2], weights[w + 3]
            x0, x1, x2, x3 = U(k * {tile}), U((k + 1) * {tile}), U((k + 2) * {tile}), U((k + 3) * {tile})
            for i in range({tile}):
                e = U(i)
                p, q, r, s = x[x0 + e], x[x1 + e], x[x2 + e], x[x3 + e]
                out[o0 + e] = out[o0 + e] + a0 * p + a1 * q + a2 * r + a3 * s
                out[o1 + e] = out[o1 + e] + b0 * p + b1 * q + b2 * r + b3 * s
                out[o2 + e] = out[o2 + e] + c0 * p + c1 * q + c2 * r + c3 * s
                out[o3 + e] = out[o3 + e] + d0 * p + d1 * q + d2 * r + d3 * s
    return at + n_out * (n_in + 1)
"""

ONE_BY_ONE = """

@jit
def dense(x, out, weights, at, n_in, n_out, fresh):
    '''out (n_out,) = bias + W x, or out + W x; weights[at:] hold n_out biases, then W^T (n_in, n_out).'''
    if fresh:
        for j in range(n_out):
            out[U(j)] = weights[U(at) + U(j)]
    for k in range(0, n_in, 4):
        p, q, r, s = x[k], x[k + 1], x[k + 2], x[k + 3]
        w0 = U(at + n_out * (k + 1))
        w1, w2, w3 = w0 + U(n_out), w0 + U(2 * n_out), w0 + U(3 * n_out)
        for j in range(n_out):
            e = U(j)
            out[e] = out[e] + weights[w0 + e] * p + weights[w1 + e] * q + weights[w2 + e] * r + weights[w3 + e] * s
    return at + n_out * (n_in + 1)
"""

NETWORK = """

@jit
def network(state, drive, weights, scratch, torque):
    x, y, z = scratch[:{x}], scratch[{x} : {x} + {h}], scratch[{x} + {h} : {x} + 2 * {h}]
    x[:] = real(0.0)
    for tile in range({tiles}):
        for r in range({rows}):  # angles and rates, then volts
            for i in range({tile}):
                x[r * {tile} + i] = state[r * {lanes} + tile * {tile} + i]
        for r in range({volts}):
            for i in range({tile}):
                x[({rows} + r) * {tile} + i] = drive[r * {lanes} + tile * {tile} + i]
        at = 0
{layers}
        dense(x, y, weights, at, {n_in}, {n_out}, False)
        for r in range({volts}):
            for i in range({tile}):
                torque[r * {lanes} + tile * {tile} + i] = y[r * {tile} + i]
"""

LAYER = """        at = dense({x}, {out}, weights, at, {n_in}, {n_out}, True)
"""
ACTIVATE = """        for i in range({size}):
            {out}[U(i)] = tanh({out}[U(i)])
"""


def padded(n: int) -> int:
    """Next multiple of BLOCK."""
    return -(-n // BLOCK) * BLOCK


def tile_of(lanes: int) -> int:
    """Lanes in a tile."""
    return 1 if lanes <= NARROW else math.gcd(lanes, TILE)


def scratch(sizes: Sequence[int]) -> int:
    """Scratch numbers: inputs and two activations of a tile."""
    return TILE * (padded(sizes[0]) + 2 * max(map(padded, sizes[1:])))


def source(sizes: Sequence[int], *, lanes: int, legs: int) -> str:
    """Source of `network(state, drive, weights, scratch, torque)` over `lanes` lanes of a network for `legs` legs."""
    tile, n = tile_of(lanes), [padded(size) for size in sizes]
    series = "real(1.0)"
    for k in range(TERMS, 1, -1):
        series = f"real(1.0) + y * real({1 / k!r}) * ({series})"
    doubled = "\n".join(["    u = u * (u + real(2.0))"] * DOUBLINGS)
    layers, x, out = "", "x", "y" if len(n) % 2 == 0 else "z"  # so that the last layer ends in y
    for i, (n_in, n_out) in enumerate(zip(n, n[1:], strict=False)):
        layers += LAYER.format(x=x, out=out, n_in=n_in, n_out=n_out)
        if i < len(n) - 2:
            layers += ACTIVATE.format(out=out, size=n_out * tile)
        x, out = out, "z" if out == "y" else "y"
    body = NETWORK.format(
        x=tile * n[0], h=tile * max(n[1:]), rows=4 * legs, volts=2 * legs, tile=tile, tiles=lanes // tile, lanes=lanes,
        layers=layers.rstrip("\n"), n_in=n[0], n_out=n[-1],
    )  # fmt: skip
    head = HEAD.format(flat=FLAT, scale=2.0 / 2**DOUBLINGS, series=series, doublings=doubled)
    return head + (ONE_BY_ONE if tile == 1 else TILED.format(tile=tile)) + body


def pack(arrays: Mapping[str, np.ndarray], layers: int) -> np.ndarray:
    """Weights in the order in which `dense` reads them: for each layer biases and W^T, last the skip, which has no biases."""
    parts = [(arrays[f"w{i}"], arrays[f"b{i}"]) for i in range(layers)] + [(arrays["skip"], np.zeros(len(arrays["skip"])))]
    packed = []
    for w, b in parts:
        n_out, n_in = w.shape
        whole = np.zeros((1 + padded(n_in), padded(n_out)))
        whole[0, :n_out], whole[1 : 1 + n_in, :n_out] = b, w.T
        packed.append(whole.ravel())
    return np.concatenate(packed)
