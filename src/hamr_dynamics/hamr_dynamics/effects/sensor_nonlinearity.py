"""A sensor whose scale is curved."""

from __future__ import annotations

from ..scalar import maximum
from .law import Effect, Form, Parameter, Signal

NODES = range(-4, 5)  # of the correction curve, in units of its step


def polynomial(x: Signal, p, z):
    """y + n2 y^2 + n3 y^3."""
    return x.y + x.y * x.y * (p["second"] + p["third"] * x.y), z


def curve(x: Signal, p, z):
    """y + a cubic spline of y through nine nodes: a calibration curve."""
    at, extra = x.y / p["step"], 0.0
    for i, node in enumerate(NODES):
        extra = extra + p[f"c{i}"] * bump(at - node)
    return x.y + extra, z


def bump(x):
    """Cubic B-spline over -2..2, of area 1."""
    a = maximum(x, -x)
    wide, narrow = maximum(2.0 - a, 0.0), maximum(1.0 - a, 0.0)
    return (wide * wide * wide - 4.0 * narrow * narrow * narrow) / 6.0


EFFECT = Effect(
    name="sensor_nonlinearity",
    part="sensor",
    summary="A reading that is a curved function of the joint's angle.",
    forms=(Form("polynomial", "sense", polynomial, (
        Parameter("second", "1/Q", 0.01, -1.0, 1.0, "per squared reading"),
        Parameter("third", "1/Q^2", 0.01, -1.0, 1.0, "per cubed reading"),
    ), order=3), Form("curve", "sense", curve, (
        *(Parameter(f"c{i}", "Q", 0.01, -1.0, 1.0, f"weight of node {node}") for i, node in enumerate(NODES)),
        Parameter("step", "Q", 0.55, 0.1, 3.0, "between nodes", shape=True, screen=(0.55,)),
    ), order=3)),
    experiment="a second sensor on the same joint, over the whole range",
    source="gap_method 3.2 (sensor gain, misalignment, eccentric discs)",
)  # fmt: skip
