"""A spring between the actuator and the joint."""

from __future__ import annotations

from .backlash import SHARE
from .law import Effect, Form, Joint, Parameter, Push


def static(x: Joint, p, z):
    """A light actuator with its own spring works on the joint through another spring and runs ahead of it under load."""
    spring = p["share"] * x.stiffness
    carried = (x.drive - spring * x.q) / (1.0 + p["compliance"] * spring)
    slip = p["compliance"] * carried
    lost = p["compliance"] * spring / (1.0 + p["compliance"] * spring)
    return Push(-(spring * slip), stiffness=-(spring * lost), slip=slip), z


EFFECT = Effect(
    name="serial_compliance",
    part="transmission",
    summary="A compliance between the actuator and the joint, so that the two do not move together under load.",
    forms=(Form("static", "force", static, (Parameter("compliance", "Q/F", 0.1, 0.0, 20.0, "of the spring in series"), SHARE)),),
    experiment="actuator deflection and joint angle side by side",
    source="hamr_facts 7, effect 1 (actuator base, off-axis flexure twist)",
    same_as={"gain and stiffness": "without a sensor on the actuator's side"},
    needs=("deflections",),
)
