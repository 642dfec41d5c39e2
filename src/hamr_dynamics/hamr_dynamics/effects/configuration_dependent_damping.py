"""Damping that depends on where the joint is."""

from __future__ import annotations

from .law import Effect, Form, Joint, Parameter, Push


def polynomial(x: Joint, p, z):
    """-(d1 q + d2 q^2) v."""
    d = x.q * (p["slope"] + p["curvature"] * x.q)
    return Push(-(d * x.v), damping=d), z


EFFECT = Effect(
    name="configuration_dependent_damping",
    part="transmission",
    summary="Viscous damping of a joint that changes with its angle.",
    forms=(Form("polynomial", "force", polynomial, (
        Parameter("slope", "F*T/Q^2", 0.02, -2.0, 2.0, "change of damping per angle"),
        Parameter("curvature", "F*T/Q^3", 0.02, -2.0, 2.0, "change per squared angle"),
    )),),
    experiment="small motions about several angles",
    source="varying levers in front of constant dampers: HAMR-full's transmission",
)  # fmt: skip
