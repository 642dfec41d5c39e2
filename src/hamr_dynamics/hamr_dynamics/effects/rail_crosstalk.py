"""The drives of a leg pull on a common rail."""

from __future__ import annotations

from .law import Effect, Form, Input, Parameter


def share(x: Input, p, z):
    """u + share times the sum of the other drives."""
    others = 0.0
    for i, u in enumerate(x.all):
        if i != x.own:
            others = others + u
    return x.u + p["share"] * others, z


EFFECT = Effect(
    name="rail_crosstalk",
    part="actuator",
    summary="A share of the other joint's drive voltage appears on this joint's.",
    forms=(Form("share", "drive", share, (Parameter("share", "1", 0.02, -0.5, 0.5, "of the other drive"),), order=3),),
    experiment="drive one joint alone and watch the other",
    source="hamr_facts 7, effect 30",
)
