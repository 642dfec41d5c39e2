"""The drive's gain depends on its voltage."""

from __future__ import annotations

from ..scalar import maximum
from .law import Effect, Form, Input, Parameter


def absolute(x: Input, p, z):
    """u (1 + a |u|)."""
    return x.u + p["slope"] * maximum(x.u, -x.u) * x.u, z


def polynomial(x: Input, p, z):
    """u (1 + b u + c u^2): other gains for the two signs too."""
    return x.u + x.u * x.u * (p["second"] + p["third"] * x.u), z


EFFECT = Effect(
    name="voltage_dependent_gain",
    part="actuator",
    summary="A piezo coefficient that grows with the field.",
    forms=(
        Form("absolute", "drive", absolute, (Parameter("slope", "1/U", 0.03, -0.3, 3.0, "relative gain per volt"),), order=5),
        Form("polynomial", "drive", polynomial, (
            Parameter("second", "1/U", 0.03, -1.0, 1.0, "even part"),
            Parameter("third", "1/U^2", 0.03, -0.1, 1.0, "odd part"),
        ), order=5),
    ),
    experiment="three amplitudes up to the rails, at rest and slow",
    source="hamr_facts 7, effect 13 (f31 against field)",
)  # fmt: skip
