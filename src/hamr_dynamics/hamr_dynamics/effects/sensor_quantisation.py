"""A sensor with coarse steps."""

from __future__ import annotations

from ..scalar import clip, floor, positive
from .law import Effect, Form, Parameter, Signal


def rounding(x: Signal, p, z):
    """The nearest multiple of a step, counted from an offset."""
    return coarse(x.y, x.y, p), z


def hysteresis(x: Signal, p, z):
    """The same of an angle that follows with play: a counter that moves on late, whichever way it is turned."""
    play = p["stick"] * p["step"]
    (now,) = (clip(z[0], x.y - play, x.y + play),)
    return coarse(now, x.y, p), (now,)


def coarse(seen, y, p):
    """The nearest step to what is seen; y itself where there are none."""
    on = positive(p["step"])
    step = p["step"] + (1.0 - on)
    return y + on * (step * floor((seen - p["offset"]) / step + 0.5) + p["offset"] - y)


STEP = Parameter("step", "Q", 0.02, 0.0, 1.0, "between readings")
OFFSET = Parameter("offset", "Q", 0.0, -0.5, 0.5, "an angle that is read as it is", shape=True)
STICK = Parameter("stick", "1", 0.0, 0.0, 0.5, "share of a step by which it moves on late", shape=True)

EFFECT = Effect(
    name="sensor_quantisation",
    part="sensor",
    summary="A reading that knows multiples of a step only.",
    forms=(
        Form("rounding", "sense", rounding, (STEP, OFFSET), order=4),
        Form("hysteresis", "sense", hysteresis, (STEP, OFFSET, STICK), states=1, order=4),
    ),
    experiment="slow motion: the readings themselves show the steps",
    source="gap_method 3.2",
    smooth=False,
)  # fmt: skip
