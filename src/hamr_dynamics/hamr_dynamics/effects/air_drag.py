"""The air brakes the chassis."""

from __future__ import annotations

from ..scalar import sqrt
from ..vec import dot, scale
from .law import Effect, Form, Motion, Parameter


def quadratic(x: Motion, p, z):
    """-coefficient |velocity| velocity."""
    return scale(x.velocity, -(p["coefficient"] * sqrt(dot(x.velocity, x.velocity)))), z


EFFECT = Effect(
    name="air_drag",
    part="body",
    summary="Drag of the chassis that grows with the square of its speed.",
    forms=(Form("quadratic", "tow", quadratic, (
        Parameter("coefficient", "N*T^2/L^2", 1e-5, 0.0, 1e-2, "force over squared speed; half density times area times drag coefficient"),
    )),),
    experiment="the fastest gait, or a jump",
    source="drag of a body at high Reynolds number; hamr_facts 7, effect 27",
    same_as={"quadratic_damping": "suspended, where air drag acts on the legs alone"},
    needs=("ground",),
)  # fmt: skip
