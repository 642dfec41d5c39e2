"""The drive comes late, unchanged."""

from __future__ import annotations

from .law import Effect, Form, Input, Parameter

DELAY = Parameter("delay", "T", 0.2, 0.0, 5.0, "by how much")


def late(signal, delay, step, z):
    """A signal by `delay` late: all-pass of order two (Pade), whose phase is exact to (w delay)^5 / 720.

    y = u - delay dx/dt with delay^2/12 x'' + delay/2 x' + x = u, by the midpoint rule, so that no delay leaves u as it is.
    """
    x, rate = z
    inertia, damping = delay * delay * (1.0 / 12.0), 0.5 * delay
    push = signal - x - damping * rate - 0.5 * step * rate
    gain = step / (inertia + 0.5 * step * damping + 0.25 * step * step)
    new_rate = rate + gain * push
    middle = 0.5 * (rate + new_rate)
    return signal - delay * middle, (x + step * middle, new_rate)


def pade(x: Input, p, z):
    """u(t - delay)."""
    return late(x.u, p["delay"], x.step, z)


EFFECT = Effect(
    name="drive_delay",
    part="actuator",
    summary="The drive acts some time after it was commanded.",
    forms=(Form("pade", "drive", pade, (DELAY,), states=2, order=1),),
    experiment="closed loop, or a second sensor: in open loop a delay of everything is a shift of the clock",
    source="hamr_facts 7, effect 20",
    mimics=("drive_lag",),  # below its corner a lag is a delay
    same_as={"sensor_latency": "in open loop, when all sensors of what it drives are equally late"},
)
