"""Feet and ground that give way more or less than the model's."""

from __future__ import annotations

from dataclasses import replace

from .law import Effect, Foot, Form, Parameter


def factor(x: Foot, p, z):
    """Contact stiffness and damping, each times (1 + its change)."""
    return replace(x, stiffness=x.stiffness * (1.0 + p["stiffness"]), damping=x.damping * (1.0 + p["damping"])), z


EFFECT = Effect(
    name="ground_compliance",
    part="contact",
    summary="Another stiffness or damping between a foot and the ground.",
    forms=(Form("factor", "foot", factor, (
        Parameter("stiffness", "1", 0.3, -0.95, 5.0, "relative change of contact stiffness"),
        Parameter("damping", "1", 0.3, -0.95, 5.0, "relative change of contact damping"),
    )),),
    experiment="touch-downs: depth and duration of the contact, bouncing",
    source="gap_method 3.2 (contact stiffness, damping)",
    needs=("ground",),
)  # fmt: skip
