"""A sensor with coarse steps."""

from __future__ import annotations

from ..scalar import floor, positive
from .law import Effect, Form, Parameter, Signal


def rounding(x: Signal, p, z):
    """The nearest multiple of a step, counted from an offset."""
    coarse = positive(p["step"])
    step = p["step"] + (1.0 - coarse)
    way = x.y - p["offset"]
    return x.y + coarse * (step * floor(way / step + 0.5) - way), z


EFFECT = Effect(
    name="sensor_quantisation",
    part="sensor",
    summary="A reading that knows multiples of a step only.",
    forms=(
        Form("rounding", "sense", rounding, (
            Parameter("step", "Q", 0.02, 0.0, 1.0, "between readings"),
            Parameter("offset", "Q", 0.0, -0.5, 0.5, "an angle that is read as it is", shape=True),
        ), order=4),
    ),
    experiment="slow motion: the readings themselves show the steps",
    source="gap_method 3.2",
    smooth=False,
)  # fmt: skip
