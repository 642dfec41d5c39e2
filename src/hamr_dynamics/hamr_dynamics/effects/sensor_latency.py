"""A sensor reports the past."""

from __future__ import annotations

from .drive_delay import DELAY, late
from .law import Effect, Form, Parameter, Signal


def pade(x: Signal, p, z):
    """y(t - delay)."""
    return late(x.y, p["delay"], x.step, z)


EFFECT = Effect(
    name="sensor_latency",
    part="sensor",
    summary="A joint's angle is reported some time after it was so; the other sensors are not late.",
    forms=(Form("pade", "sense", pade, (Parameter("delay", "T", 0.05, DELAY.low, DELAY.high, DELAY.doc),), states=2, order=2),),
    experiment="closed loop, or a second sensor on the same joint",
    source="hamr_facts 7, effect 20",
    mimics=("sensor_lag",),  # below its corner a lag is a latency
    same_as={"drive_delay": "in open loop, when all sensors of what it drives are equally late"},
)
