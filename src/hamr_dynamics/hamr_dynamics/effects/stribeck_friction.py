"""Dry friction that is larger near standstill than while sliding fast."""

from __future__ import annotations

from ..scalar import maximum
from .coulomb_friction import DISTANCE, LEVEL, WIDTH, gliding
from .law import Effect, Form, Joint, Parameter, Push


def lorentzian(x: Joint, p, z):
    """-(level + excess / (1 + (v/speed)^2)) sign(v)."""
    direction, slope = gliding(x.v, p["width"])
    ratio = x.v / p["speed"]
    bell = 1.0 / (1.0 + ratio * ratio)
    size = p["level"] + p["excess"] * bell
    return Push(-(size * direction), damping=size * slope), z


def bristles(x: Joint, p, z):
    """LuGre: bristles yield over a distance, and what they bear falls with speed; -size z, dz/dt = (v - |v| z) / distance."""
    ratio = x.v / p["speed"]
    size = p["level"] + p["excess"] / (1.0 + ratio * ratio)
    pace = x.step / p["distance"]
    speed = maximum(x.v, -x.v)
    new = (z[0] + pace * x.v) / (1.0 + pace * speed)
    yielding = maximum(1.0 - maximum(new, -new), 0.0)
    return Push(-(size * new), stiffness=size * yielding / p["distance"]), (new,)


EXCESS = Parameter("excess", "F", 0.05, 0.0, 10.0, "how much larger it is near standstill")
SPEED = Parameter("speed", "Q/T", 0.3, 0.01, 5.0, "rate at which half the excess is left", shape=True, screen=(0.1, 0.4))

EFFECT = Effect(
    name="stribeck_friction",
    part="transmission",
    summary="Dry friction of a joint that falls from a larger value near standstill to a smaller one with speed.",
    forms=(
        Form("lorentzian", "force", lorentzian, (LEVEL, EXCESS, SPEED, WIDTH)),
        Form("bristles", "force", bristles, (LEVEL, EXCESS, SPEED, DISTANCE), states=1),
    ),  # fmt: skip
    experiment="slow breakaway ramps and constant speeds",
    source="Stribeck 1902; LuGre: Canudas de Wit et al. 1995; Olsson et al. 1998, Friction models and friction compensation",
    contains=("coulomb_friction",),
)
