"""A sensor is slow."""

from __future__ import annotations

from .drive_lag import lagging
from .law import Effect, Form, Parameter, Signal


def first_order(x: Signal, p, z):
    """time dy'/dt = y - y'."""
    return lagging(x.y, p["time"], x.step, z)


EFFECT = Effect(
    name="sensor_lag",
    part="sensor",
    summary="A joint's angle is read through a low-pass.",
    forms=(Form("first_order", "sense", first_order, (Parameter("time", "T", 0.05, 0.0, 20.0, "time constant"),), states=1, order=1),),
    experiment="a second sensor on the same joint, at frequencies beyond the corner",
    source="gap_method 3.2",
    same_as={"drive_lag": "in open loop while the joint is linear, without a second sensor"},
)
