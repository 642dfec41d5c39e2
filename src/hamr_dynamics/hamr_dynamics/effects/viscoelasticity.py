"""A spring that relaxes: the standard linear solid."""

from __future__ import annotations

from .law import Effect, Form, Joint, Parameter, Push


def maxwell(x: Joint, p, z):
    """-k (q - z), dz/dt = (q - z) / time."""
    share = p["time"] / (p["time"] + x.step)
    moved = z[0] * share + x.q * (1.0 - share)
    return Push(-(p["stiffness"] * (x.q - moved)), stiffness=p["stiffness"] * share), (moved,)


EFFECT = Effect(
    name="viscoelasticity",
    part="transmission",
    summary="A part of a joint's spring that relaxes with one time of its own.",
    forms=(Form("maxwell", "force", maxwell, (
        Parameter("stiffness", "F/Q", 0.05, 0.0, 10.0, "stiffness that relaxes"),
        Parameter("time", "T", 3.0, 0.02, 3000.0, "relaxation time", shape=True, screen=(0.3, 3.0, 30.0, 300.0)),
    ), states=1),),
    experiment="holds of several relaxation times beside fast motion",
    source="hamr_facts 7, effect 23 (polyimide relaxation); Maxwell element",
)  # fmt: skip
