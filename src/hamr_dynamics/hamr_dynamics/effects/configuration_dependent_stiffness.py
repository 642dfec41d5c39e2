"""Stiffness that depends on where the leg is: the gradient of a potential of both angles."""

from __future__ import annotations

from ..scalar import cos, sin, sqrt
from .configuration_dependent_damping import CENTRE, WIDTH, bell
from .law import Effect, Form, Joint, Pair, PairPush, Parameter, Push


def potential(x: Pair, p, z):
    """Force -grad V, V = sum of monomials s^i l^j of the two angles up to the fourth degree; s^2 and l^2 are changes of stiffness."""
    s, r = x.q
    c11 = p["c11"]
    c30, c21, c12, c03 = (p[f"c{i}"] for i in ("30", "21", "12", "03"))
    c40, c31, c22, c13, c04 = (p[f"c{i}"] for i in ("40", "31", "22", "13", "04"))
    along = c11 * r + s * (3.0 * c30 * s + 2.0 * c21 * r) + c12 * r * r
    along = along + s * (s * (4.0 * c40 * s + 3.0 * c31 * r) + 2.0 * c22 * r * r) + c13 * r * r * r
    across = c11 * s + r * (3.0 * c03 * r + 2.0 * c12 * s) + c21 * s * s
    across = across + r * (r * (4.0 * c04 * r + 3.0 * c13 * s) + 2.0 * c22 * s * s) + c31 * s * s * s
    k11 = 6.0 * c30 * s + 2.0 * c21 * r + 12.0 * c40 * s * s + 6.0 * c31 * s * r + 2.0 * c22 * r * r
    k12 = c11 + 2.0 * c21 * s + 2.0 * c12 * r + 3.0 * c31 * s * s + 4.0 * c22 * s * r + 3.0 * c13 * r * r
    k22 = 6.0 * c03 * r + 2.0 * c12 * s + 12.0 * c04 * r * r + 6.0 * c13 * s * r + 2.0 * c22 * s * s
    return PairPush((-along, -across), stiffness=(k11, k12, k22)), z


def well(x: Joint, p, z):
    """Force of the potential -depth / (1 + ((q - centre)/width)^2): a soft or stiff place in the travel."""
    near, at = bell(x.q, p)
    k = 2.0 * p["depth"] * near * near / (p["width"] * p["width"])
    return Push(-(k * (x.q - p["centre"])), stiffness=k * (1.0 - 4.0 * at * at * near)), z


def valley(x: Joint, p, z):
    """Force of the potential stiffness width^2 sqrt(1 + ((q - centre)/width)^2): a spring near the centre, a constant force far off."""
    force, stiffness = _valley(x.q, p)
    return Push(force, stiffness=stiffness), z


def oblique(x: Pair, p, z):
    """The same across both angles, with cos(direction) swing + sin(direction) lift as q: a hinge whose axis is oblique to the joints'."""
    along, across = cos(p["direction"]), sin(p["direction"])
    force, k = _valley(along * x.q[0] + across * x.q[1], p)
    return PairPush((along * force, across * force), stiffness=(k * along * along, k * along * across, k * across * across)), z


def _valley(q, p):
    """Force and stiffness of a valley."""
    at = (q - p["centre"]) / p["width"]
    slant = 1.0 / sqrt(1.0 + at * at)
    return -(p["stiffness"] * p["width"] * at * slant), p["stiffness"] * slant * slant * slant


def _term(i: int, j: int) -> Parameter:
    power = i + j - 1
    return Parameter(f"c{i}{j}", f"F/Q^{power}" if power > 1 else "F/Q", 0.01, -5.0, 5.0, f"potential per swing^{i} lift^{j}")


STIFFNESS = Parameter("stiffness", "F/Q", 0.05, -5.0, 5.0, "in the centre")
DIRECTION = Parameter("direction", "1", 0.8, -2.4, 2.4, "in the plane of swing and lift, rad", shape=True, screen=(-1.0, -0.4, 0.4, 1.0))

EFFECT = Effect(
    name="configuration_dependent_stiffness",
    part="transmission",
    summary="Springs whose stiffness changes with both angles of the leg, as a potential has it.",
    forms=(Form("well", "force", well, (Parameter("depth", "F*Q", 0.02, -5.0, 5.0, "of the potential"), CENTRE, WIDTH)),
           Form("valley", "force", valley, (STIFFNESS, CENTRE, WIDTH)),
           Form("oblique", "pair", oblique, (STIFFNESS, DIRECTION, CENTRE, WIDTH)),
           Form("potential", "pair", potential,
                (_term(1, 1), *(_term(i, n - i) for n in (3, 4) for i in range(n, -1, -1)))),),
    experiment="large motions of both joints at once",
    source="hamr_facts 7, effect 8; Gruenstein et al., Residual Model Learning for Microrobot Control",
    contains=("cubic_stiffness", "lift_swing_coupling"),
)  # fmt: skip
