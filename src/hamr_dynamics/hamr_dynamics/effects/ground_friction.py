"""Ground that is more or less slippery than the model's."""

from __future__ import annotations

from dataclasses import replace

from .law import Effect, Foot, Form, Parameter


def factor(x: Foot, p, z):
    """Coefficient times (1 + change)."""
    return replace(x, friction=x.friction * (1.0 + p["change"])), z


EFFECT = Effect(
    name="ground_friction",
    part="contact",
    summary="Another friction coefficient under a foot.",
    forms=(Form("factor", "foot", factor, (Parameter("change", "1", 0.2, -1.0, 5.0, "relative change of the coefficient"),)),),
    experiment="walking and turning with feet that slip",
    source="gap_method 3.2 (contact)",
    needs=("ground",),
)
