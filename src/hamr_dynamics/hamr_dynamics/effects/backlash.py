"""Play between the actuator and the joint."""

from __future__ import annotations

from ..scalar import clip
from .law import Effect, Form, Joint, Parameter, Push

SHARE = Parameter("share", "1", 0.7, 0.02, 1.0, "share of the joint's stiffness on the actuator's side", shape=True, screen=(0.3, 0.8))


def dead_band(x: Joint, p, z):
    """A light actuator with its own spring pushes only at the ends of the play; in between it moves ahead of the joint alone."""
    spring = p["share"] * x.stiffness
    ahead = x.drive / spring - x.q  # where the actuator would come to rest by itself
    slip = clip(ahead, -p["play"], p["play"])
    return Push(-(spring * slip), slip=slip), z


EFFECT = Effect(
    name="backlash",
    part="transmission",
    summary="Play in which the actuator moves and the joint does not follow.",
    forms=(Form("dead_band", "force", dead_band, (Parameter("play", "Q", 0.02, 0.0, 2.0, "half width of the play"), SHARE)),),
    experiment="small amplitudes: the joint seems softer the smaller the motion; actuator and joint angle side by side",
    source="hamr_facts 7, effects 1 and 25; Nordin and Gutman 2002, Controlling mechanical systems with backlash",
)
