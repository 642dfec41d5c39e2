"""An effect without a name: a force given as a table, for what no law explains."""

from __future__ import annotations

from ..scalar import clip, maximum
from .law import Effect, Form, Input, Joint, Parameter, Push

NODES = 5  # along each axis, -2 to 2 times the usual value; flat beyond


def hats(x, nodes: int = NODES) -> list:
    """Weights of the nodes -2..2 at x: hats of width 1, whose sum is 1; beyond the table those of its edge."""
    at = [i - 0.5 * (nodes - 1) for i in range(nodes)]
    x = clip(x, at[0], at[-1])
    return [maximum(1.0 - maximum(x - a, a - x), 0.0) for a in at]


def angle_rate(x: Joint, p, z):
    """Force from a table over angle and rate."""
    along, across = hats(x.q / p["angle"]), hats(x.v / p["rate"])
    force = 0.0
    for i, a in enumerate(along):
        for j, b in enumerate(across):
            force = force + p[f"f{i}{j}"] * a * b
    return Push(force), z


def drive_curve(x: Input, p, z):
    """Drive from a table over the commanded drive: u plus what the table adds."""
    extra = 0.0
    for i, a in enumerate(hats(x.u / p["unit"], 7)):
        extra = extra + p[f"u{i}"] * a
    return x.u + extra, z


EFFECT = Effect(
    name="force_table",
    part="transmission",
    summary="A force, or a change of the drive, that is known as a table only.",
    forms=(
        Form("angle_rate", "force", angle_rate, (
            *(Parameter(f"f{i}{j}", "F", 0.01, -10.0, 10.0, f"force at angle node {i}, rate node {j}")
              for i in range(NODES) for j in range(NODES)),
            Parameter("angle", "Q", 1.2, 0.1, 10.0, "between angle nodes", shape=True, screen=(0.6, 1.2)),
            Parameter("rate", "Q/T", 1.2, 0.1, 10.0, "between rate nodes", shape=True, screen=(0.4, 1.2)),
        )),
        Form("drive_curve", "drive", drive_curve, (
            *(Parameter(f"u{i}", "U", 0.03, -2.0, 2.0, f"added at drive node {i}") for i in range(7)),
            Parameter("unit", "U", 0.8, 0.1, 10.0, "between nodes", shape=True, screen=(0.8,)),
        ), order=9),
    ),
    experiment="none: it stands for a law that is not known",
    source="latent restoring force, Rogers and Friis 2021, as hat functions",
    needs=("unnamed",),
)  # fmt: skip
