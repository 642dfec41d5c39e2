"""Dry friction of a joint: a force of constant size against the motion."""

from __future__ import annotations

from ..scalar import maximum, sqrt
from .law import Effect, Form, Joint, Parameter, Push

LEVEL = Parameter("level", "F", 0.05, 0.0, 10.0, "friction force while sliding")
WIDTH = Parameter("width", "Q/T", 0.02, 1e-4, 0.3, "rate at which the force has reached 0.7 of its level", shape=True, screen=(0.02,))
DISTANCE = Parameter("distance", "Q", 0.03, 1e-4, 1.0, "way over which bristles yield before sliding", shape=True, screen=(0.01, 0.1))


def gliding(v, width):
    """Sign of a rate, smooth within `width`, and its slope."""
    size = sqrt(v * v + width * width)
    return v / size, width * width / (size * size * size)


def sign(x: Joint, p, z):
    """-level sign(v)."""
    direction, slope = gliding(x.v, p["width"])
    return Push(-(p["level"] * direction), damping=p["level"] * slope), z


def asymmetric(x: Joint, p, z):
    """-level sign(v) - difference: other sizes in the two directions."""
    direction, slope = gliding(x.v, p["width"])
    size = p["level"] + p["difference"] * direction
    return Push(-(size * direction), damping=(size + p["difference"] * direction) * slope), z


def presliding(x: Joint, p, z):
    """Dahl: -level z, dz/dt = (v - |v| z) / distance; elastic before it slides."""
    pace = x.step / p["distance"]
    speed = maximum(x.v, -x.v)
    new = (z[0] + pace * x.v) / (1.0 + pace * speed)
    yielding = maximum(1.0 - maximum(new, -new), 0.0)
    return Push(-(p["level"] * new), stiffness=p["level"] * yielding / p["distance"]), (new,)


EFFECT = Effect(
    name="coulomb_friction",
    part="transmission",
    summary="A friction force of constant size against the motion of a joint.",
    forms=(
        Form("sign", "force", sign, (LEVEL, WIDTH)),
        Form("presliding", "force", presliding, (LEVEL, DISTANCE), states=1),
        Form("asymmetric", "force", asymmetric,
             (LEVEL, Parameter("difference", "F", 0.01, -10.0, 10.0, "half the difference of the two directions"), WIDTH)),
    ),  # fmt: skip
    experiment="small slow reversals beside large fast ones: the equivalent damping falls as one over the amplitude",
    source="Coulomb 1785; presliding: Dahl 1968; robot joints: Janot, Gautier, Brunot 2019 (EMPS)",
)
