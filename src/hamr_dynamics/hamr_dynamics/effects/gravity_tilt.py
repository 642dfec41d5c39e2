"""Ground that is not level."""

from __future__ import annotations

from dataclasses import replace
from math import cos, sin

from .law import Chassis, Effect, Form, Parameter


def slope(x: Chassis, p, z):
    """Gravity as axes on the slope see it: ground turned by `roll` about x, then by `pitch` about its y (nose down)."""
    a, b = p["roll"], p["pitch"]
    x0, y0, z0 = x.gravity
    y1, z1 = cos(a) * y0 + sin(a) * z0, cos(a) * z0 - sin(a) * y0
    return replace(x, gravity=(cos(b) * x0 - sin(b) * z1, y1, cos(b) * z1 + sin(b) * x0)), z


EFFECT = Effect(
    name="gravity_tilt",
    part="body",
    summary="A slope: the ground is flat but not level.",
    forms=(Form("slope", "chassis", slope, (
        Parameter("roll", "Q", 0.05, -1.0, 1.0, "of the ground about x: left side up if positive"),
        Parameter("pitch", "Q", 0.05, -1.0, 1.0, "of the ground about y: nose down if positive"),
    )),),
    experiment="the same gait in two directions on the same ground",
    source="gap_method 3.2 (gravity tilt)",
    needs=("ground",),
)  # fmt: skip
