"""A spring that hardens or softens."""

from __future__ import annotations

from .law import Effect, Form, Joint, Parameter, Push

CUBIC = Parameter("cubic", "F/Q^3", 0.02, -5.0, 5.0, "force over cubed angle; positive hardens")


def cubic(x: Joint, p, z):
    """-k3 q^3."""
    k = p["cubic"] * x.q * x.q
    return Push(-(k * x.q), stiffness=3.0 * k), z


def mixed(x: Joint, p, z):
    """-(k2 q^2 + k3 q^3): asymmetric too."""
    return Push(-(x.q * x.q * (p["quadratic"] + p["cubic"] * x.q)), stiffness=x.q * (2.0 * p["quadratic"] + 3.0 * p["cubic"] * x.q)), z


EFFECT = Effect(
    name="cubic_stiffness",
    part="transmission",
    summary="A joint's spring that hardens or softens with deflection.",
    forms=(
        Form("cubic", "force", cubic, (CUBIC,)),
        Form("mixed", "force", mixed, (Parameter("quadratic", "F/Q^2", 0.02, -5.0, 5.0, "force over squared angle"), CUBIC)),
    ),
    experiment="two amplitudes: the resonance moves with amplitude, odd harmonics appear",
    source="hamr_facts 7, effect 3; Duffing 1918; Wigren and Schoukens 2013 (Silverbox)",
)
