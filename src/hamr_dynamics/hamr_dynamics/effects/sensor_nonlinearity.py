"""A sensor whose scale is curved."""

from __future__ import annotations

from .law import Effect, Form, Parameter, Signal


def polynomial(x: Signal, p, z):
    """y + n2 y^2 + n3 y^3."""
    return x.y + x.y * x.y * (p["second"] + p["third"] * x.y), z


EFFECT = Effect(
    name="sensor_nonlinearity",
    part="sensor",
    summary="A reading that is a curved function of the joint's angle.",
    forms=(Form("polynomial", "sense", polynomial, (
        Parameter("second", "1/Q", 0.01, -1.0, 1.0, "per squared reading"),
        Parameter("third", "1/Q^2", 0.01, -1.0, 1.0, "per cubed reading"),
    ), order=3),),
    experiment="a second sensor on the same joint, over the whole range",
    source="gap_method 3.2 (sensor gain, misalignment)",
)  # fmt: skip
