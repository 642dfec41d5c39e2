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


CENTRE = Parameter("centre", "Q", 0.0, -3.0, 3.0, "angle of the middle", shape=True, screen=(-1.0, 0.0, 1.0))
WIDTH = Parameter("width", "Q", 0.8, 0.1, 10.0, "angle from the middle at which half is left", shape=True, screen=(0.5, 1.5))


def bell(q, p):
    """1 / (1 + ((q - centre)/width)^2), and its argument."""
    at = (q - p["centre"]) / p["width"]
    return 1.0 / (1.0 + at * at), at


def local(x: Joint, p, z):
    """-extra v near one angle."""
    return _passive(x, p["extra"] * bell(x.q, p)[0]), z


EFFECT = Effect(
    name="configuration_dependent_damping",
    part="transmission",
    summary="Viscous damping of a joint that changes with its angle.",
    forms=(Form("polynomial", "force", polynomial, (
        Parameter("slope", "F*T/Q^2", 0.02, -2.0, 2.0, "change of damping per angle"),
        Parameter("curvature", "F*T/Q^3", 0.02, -2.0, 2.0, "change per squared angle"),
    )), Form("local", "force", local, (
        Parameter("extra", "F*T/Q", 0.03, -2.0, 5.0, "damping added in the middle"), CENTRE, WIDTH,
    ))),
    experiment="small motions about several angles",
    source="varying levers in front of constant dampers: HAMR-full's transmission",
)  # fmt: skip
