"""A payload on the chassis."""

from __future__ import annotations

from ..vec import add, point_inertia, scale, sub
from .law import Chassis, Effect, Form, Parameter


def point(x: Chassis, p, z):
    """A point mass fixed to the chassis: mass, centre of mass and inertia of both together."""
    at, mass = (p["x"], p["y"], p["z"]), x.mass + p["mass"]
    com = add(x.com, scale(sub(at, x.com), p["mass"] / mass))
    inertia = add(x.inertia, add(point_inertia(x.mass, sub(x.com, com)), point_inertia(p["mass"], sub(at, com))))
    return Chassis(mass, com, inertia, x.gravity), z


#: mm: at an end, at a side, on top; a payload at the centre is next to none, for a re-tune takes up its weight.
SEATS = {"x": (0.0, -10.0, 10.0), "y": (0.0, -5.0, 5.0), "z": (0.0, 10.0)}

EFFECT = Effect(
    name="added_mass",
    part="body",
    summary="A payload that the chassis carries.",
    forms=(Form("point", "chassis", point, (
        Parameter("mass", "M", 0.1, 0.0, 5.0, "of the payload"),
        *(Parameter(axis, "L", 0.0, -50.0, 50.0, f"where it is, {axis} in base_link", shape=True, screen=screen)
          for axis, screen in SEATS.items()),
    )),),
    experiment="standing and walking: the legs sag by weight over leg stiffness, strides change",
    source="hamr_facts 7; gap_method 3.2 (body)",
    needs=("ground",),
)  # fmt: skip
