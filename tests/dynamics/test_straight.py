"""Straight-line code means in compiled code what it means in plain Python, to the bit, in both sizes of floats."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numba import njit

from hamr_dynamics.straight import over_lanes

LANES = 5
OPERATIONS = {
    "x0 + x1": lambda a, b: a + b, "x0 - x1": lambda a, b: a - b, "x0 * x1": lambda a, b: a * b, "x0 / x1": lambda a, b: a / b,
    "-x0": lambda a, b: -a, "sqrt(x2)": lambda a, b: np.sqrt(a * a), "floor(x0)": lambda a, b: np.floor(a), "gate(x0)": lambda a, b: a > 0,
    "larger(x0, x1)": lambda a, b: a if a > b else b, "smaller(x0, x1)": lambda a, b: a if a < b else b,
}  # fmt: skip


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("operation", OPERATIONS)
def test_each_operation_is_that_of_the_floats(operation, dtype):
    text = f"""
for i in range({LANES}):
    e = U(i)
    x0 = rows[U(0)+e]
    x1 = rows[U({LANES})+e]
    x2 = x0 * x0
    x3 = {operation}
    new[U({LANES})+e] = x3
"""
    rng = np.random.default_rng(0)
    rows, new = np.array([*rng.normal(0, 3, 2 * LANES)], dtype), np.full(2 * LANES, 7.0, dtype)
    compiled(over_lanes("rows, new", text))(rows, new)
    true = [OPERATIONS[operation](*rows[[e, LANES + e]]) for e in range(LANES)]
    assert new.tolist() == [7.0] * LANES + np.array(true, dtype).tolist()


def test_what_all_lanes_share_is_read_and_rounded_once():
    text = """
c0 = real(-0.1)
x0 = all[U(1)]
for i in range(2):
    e = U(i)
    x1 = x0 * c0
    out[U(0)+e] = x1
"""
    out = np.zeros(2, np.float32)
    compiled(over_lanes("all, out", text))(np.array([1.0, 3.0], np.float32), out)
    assert out.tolist() == [np.float32(3.0) * np.float32(-0.1)] * 2


def test_a_row_may_be_written_where_it_was_read():
    text = "for i in range(3):\n    e = U(i)\n    x0 = work[U(0)+e]\n    x1 = x0 + x0\n    work[U(0)+e] = x1\n"
    compiled(over_lanes("work", text))(work := np.array([1.0, 2.0, math.inf, 4.0]))
    assert work.tolist() == [2.0, 4.0, math.inf, 4.0]


@pytest.mark.parametrize(("line", "says"), [("x0 = sin(x0)", "no 'sin"), ("x0 = work[e]", "no place"), ("x0 = x0 % x0", "no 'x0 % x0'")])
def test_what_is_not_straight_line_code_is_refused(line, says):
    function = over_lanes("work", f"for i in range(1):\n    e = U(i)\n    x0 = work[U(0)+e]\n    {line}\n    work[U(0)+e] = x0\n")
    with pytest.raises(Exception, match=says):
        compiled(function)(np.zeros(1))


def compiled(function):
    """As kernels call it."""

    one = njit(error_model="numpy")(lambda a: function(a))
    two = njit(error_model="numpy")(lambda a, b: function(a, b))
    return lambda *arrays: (one if len(arrays) == 1 else two)(*arrays)
