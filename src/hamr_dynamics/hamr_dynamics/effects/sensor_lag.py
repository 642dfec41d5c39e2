"""A sensor is slow."""

from __future__ import annotations

from .drive_lag import lagging
from .law import Effect, Form, Parameter, Signal

TIME = Parameter("time", "T", 0.05, 0.0, 20.0, "time constant")


def first_order(x: Signal, p, z):
    """time dy'/dt = y - y'."""
    return lagging(x.y, p["time"], x.step, z)


def cascade(x: Signal, p, z):
    """Three such low-passes of a third of the time each: close to a mean over twice the time, whose delay and loss they share."""
    y, after = x.y, []
    for before in z:
        y, (now,) = lagging(y, p["time"] / len(z), x.step, (before,))
        after.append(now)
    return y, tuple(after)


EFFECT = Effect(
    name="sensor_lag",
    part="sensor",
    summary="A joint's angle is read through a low-pass.",
    forms=(
        Form("first_order", "sense", first_order, (TIME,), states=1, order=1),
        Form("cascade", "sense", cascade, (TIME,), states=3, order=1),
    ),
    experiment="a second sensor on the same joint, at frequencies beyond the corner",
    source="gap_method 3.2",
    mimics=("sensor_latency",),  # below its corner it is one
    same_as={"drive_lag": "in open loop while the joint is linear, without a second sensor"},
)
