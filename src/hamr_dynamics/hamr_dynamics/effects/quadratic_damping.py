"""Damping that grows with the square of the rate."""

from __future__ import annotations

from ..scalar import maximum
from .law import Effect, Form, Joint, Parameter, Push


def square(x: Joint, p, z):
    """-c |v| v."""
    drag = p["coefficient"] * maximum(x.v, -x.v)
    return Push(-(drag * x.v), damping=2.0 * drag), z


EFFECT = Effect(
    name="quadratic_damping",
    part="transmission",
    summary="A damping force that grows with the square of a joint's rate.",
    forms=(Form("square", "force", square, (Parameter("coefficient", "F*T^2/Q^2", 0.02, 0.0, 20.0, "force over squared rate"),)),),
    experiment="decay from a large amplitude, or two amplitudes: the equivalent damping grows with the amplitude",
    source="drag of a body at high Reynolds number; hamr_facts 7, effect 27",
    same_as={"air_drag": "suspended, where air drag acts on the legs alone"},
)
