"""Damping that depends on where the joint is."""

from __future__ import annotations

from ..scalar import maximum
from .law import Effect, Form, Joint, Parameter, Push


def _passive(x: Joint, d) -> Push:
    """-d v, with no less than no damping left: a joint is no motor."""
    d = maximum(d, -x.damping)
    return Push(-(d * x.v), damping=d)


def polynomial(x: Joint, p, z):
    """-(d1 q + d2 q^2) v."""
    return _passive(x, x.q * (p["slope"] + p["curvature"] * x.q)), z


CENTRE = Parameter("centre", "Q", 0.0, -3.0, 3.0, "angle of the middle", shape=True, screen=(-2.0, -1.0, 0.0, 1.0, 2.0))
WIDTH = Parameter("width", "Q", 0.8, 0.03, 10.0, "angle from the middle at which half is left", shape=True, screen=(0.5, 1.5))


def bell(q, p):
    """1 / (1 + ((q - centre)/width)^2), and its argument."""
    at = (q - p["centre"]) / p["width"]
    return 1.0 / (1.0 + at * at), at


def local(x: Joint, p, z):
    """-extra v near one angle."""
    return _passive(x, p["extra"] * bell(x.q, p)[0]), z


APPROACH = Parameter("approach", "1/Q", 0.2, -1.5, 1.5, "share of the gap closed per angle", shape=True, screen=(-0.3, -0.15, 0.15, 0.3))
NARROWEST = 0.1  # of the gap at rest: a film does not vanish


def squeeze_film(x: Joint, p, z):
    """-film (1/h^3 - 1) v with the gap h = 1 - approach q, of its own at rest and no less than a tenth."""
    narrow = 1.0 / maximum(1.0 - p["approach"] * x.q, NARROWEST)
    return _passive(x, p["film"] * (narrow * narrow * narrow - 1.0)), z


EFFECT = Effect(
    name="configuration_dependent_damping",
    part="transmission",
    summary="Viscous damping of a joint that changes with its angle.",
    forms=(Form("polynomial", "force", polynomial, (
        Parameter("slope", "F*T/Q^2", 0.02, -2.0, 2.0, "change of damping per angle"),
        Parameter("curvature", "F*T/Q^3", 0.02, -2.0, 2.0, "change per squared angle"),
    )), Form("local", "force", local, (
        Parameter("extra", "F*T/Q", 0.03, -2.0, 5.0, "damping added in the middle"), CENTRE, WIDTH,
    )), Form("squeeze_film", "force", squeeze_film, (
        Parameter("film", "F*T/Q", 0.02, -2.0, 2.0, "damping of the film at rest, which the joint's own has in it"), APPROACH,
    ))),
    experiment="small motions about several angles",
    source="varying levers in front of constant dampers: HAMR-full's transmission; films between plates: Stefan (1874), Reynolds (1886)",
)  # fmt: skip
