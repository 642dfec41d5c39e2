"""The drive weakens or strengthens over the run."""

from __future__ import annotations

from .law import Effect, Form, Input, Parameter


def linear(x: Input, p, z):
    """u (1 + rate t)."""
    return x.u + (p["rate"] * x.time) * x.u, z


EFFECT = Effect(
    name="drive_drift",
    part="actuator",
    summary="A drive gain that changes steadily over the run.",
    forms=(Form("linear", "drive", linear, (Parameter("rate", "1/T", 1e-5, -1e-2, 1e-2, "relative change per time"),), order=8),),
    experiment="the same signal at the beginning and the end of a run",
    source="hamr_facts 7, effects 5 and 29 (ageing, temperature)",
)
