"""A joint's spring remembers where its motion turned round: flexures with glue, belts, wire ropes."""

from __future__ import annotations

from ..scalar import maximum, positive
from .dragged import dragged
from .law import Effect, Form, Joint, Parameter, Push


def bouc_wen(x: Joint, p, z):
    """-size z, dz/dt = (v - |v| z - skew v |z|) / distance (Bouc-Wen of exponent one, whose alpha, beta gamma and delta / gamma are
    size / distance, 1 / distance and skew)."""
    way = x.step * x.v
    yields = 1.0 - p["skew"] + 2.0 * p["skew"] * positive(way * z[0])  # loading, 1 + skew; unloading, 1 - skew
    new, slope = dragged(z[0], way, p["distance"], 1.0 / yields)
    return Push(-(p["size"] * new), stiffness=p["size"] * maximum(slope, 0.0)), (new,)


EFFECT = Effect(
    name="spring_hysteresis",
    part="transmission",
    summary="A loop between angle and force of a joint's spring that does not depend on how fast it is run through.",
    forms=(Form("bouc_wen", "force", bouc_wen, (
        Parameter("size", "F", 0.3, 0.0, 100.0, "force at which the loop has bent"),
        Parameter("distance", "Q", 1.0, 0.02, 20.0, "way over which a turn is forgotten", shape=True, screen=(0.5, 2.0)),
        Parameter("skew", "1", 0.0, -3.0, 1.0, "by how much more it yields on the way out than back", shape=True, screen=(-1.2, 0.0)),
    ), states=1),),
    experiment="slow triangles of two amplitudes, with minor loops",
    source="Bouc 1967, Wen 1976; benchmark of hysteresis: Noel and Schoukens 2016",
    contains=("coulomb_friction",),  # without skew, and a short way
)  # fmt: skip
