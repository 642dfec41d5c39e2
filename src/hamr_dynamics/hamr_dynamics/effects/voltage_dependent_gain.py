"""The drive's gain depends on its voltage."""

from __future__ import annotations

from ..scalar import maximum, sqrt
from .law import Effect, Form, Input, Parameter


def absolute(x: Input, p, z):
    """u (1 + a |u|)."""
    return x.u + p["slope"] * maximum(x.u, -x.u) * x.u, z


def polynomial(x: Input, p, z):
    """u (1 + b u + c u^2): other gains for the two signs too."""
    return x.u + x.u * x.u * (p["second"] + p["third"] * x.u), z


def climb(x, middle, width):
    """0 far below the middle, 1 far above."""
    way = (x - middle) / width
    return 0.5 + 0.5 * way / sqrt(1.0 + way * way)


def sigmoid(x: Input, p, z):
    """u (1 + rise s(|u|)): the coefficient climbs from one level to another about a field."""
    return x.u + p["rise"] * climb(maximum(x.u, -x.u), p["middle"], p["width"]) * x.u, z


def one_sided(x: Input, p, z):
    """u (1 + rise s(u)): the same for the signed field of one plate."""
    return x.u + p["rise"] * climb(x.u, p["middle"], p["width"]) * x.u, z


RISE = Parameter("rise", "1", 0.05, -0.8, 3.0, "relative gain above the field, over that below")
MIDDLE = Parameter("middle", "U", 1.0, 0.1, 4.0, "where it has climbed half way", shape=True, screen=(0.6, 1.6))
WIDTH = Parameter("width", "U", 0.3, 0.03, 3.0, "half width of the climb", shape=True)

EFFECT = Effect(
    name="voltage_dependent_gain",
    part="actuator",
    summary="A piezo coefficient that grows with the field.",
    forms=(
        Form("absolute", "drive", absolute, (Parameter("slope", "1/U", 0.03, -0.3, 3.0, "relative gain per volt"),), order=5),
        Form("polynomial", "drive", polynomial, (
            Parameter("second", "1/U", 0.03, -1.0, 1.0, "even part"),
            Parameter("third", "1/U^2", 0.03, -0.1, 1.0, "odd part"),
        ), order=5),
        Form("sigmoid", "drive", sigmoid, (RISE, MIDDLE, WIDTH), order=5),
        Form("one_sided", "drive", one_sided, (RISE, MIDDLE, WIDTH), order=5),
    ),
    experiment="three amplitudes up to the rails, at rest and slow",
    source="hamr_facts 2 and 7, effect 13 (f31 against field: from 14 to 29 Pa m/V about 0.4 MV/m)",
)  # fmt: skip
