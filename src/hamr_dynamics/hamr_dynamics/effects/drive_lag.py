"""The drive follows its command as a low-pass does."""

from __future__ import annotations

from .law import Effect, Form, Input, Parameter


def lagging(signal, time, step, z):
    """First-order low-pass by the midpoint rule; without a time constant the signal stays as it is."""
    (before,) = z
    y = signal - (signal - before) * (time / (time + step))
    return y, (y,)


def first_order(x: Input, p, z):
    """time du'/dt = u - u'."""
    return lagging(x.u, p["time"], x.step, z)


EFFECT = Effect(
    name="drive_lag",
    part="actuator",
    summary="The drive electronics follow the command with a time constant.",
    forms=(Form("first_order", "drive", first_order, (Parameter("time", "T", 0.2, 0.0, 20.0, "time constant"),), states=1, order=2),),
    experiment="noise or steps beyond the corner frequency: gain falls there, unlike with a delay",
    source="hamr_facts 7, effect 19 (shunt resistor and actuator capacitance)",
    mimics=("drive_delay",),  # below its corner it is one
    same_as={"sensor_lag": "in open loop while the joint is linear, without a second sensor"},
)
