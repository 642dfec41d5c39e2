"""The wires pull."""

from __future__ import annotations

from .law import Effect, Form, Motion, Parameter


def constant(x: Motion, p, z):
    """A constant force in the ground's axes."""
    return (p["x"], p["y"], p["z"]), z


def spring(x: Motion, p, z):
    """A horizontal spring to the origin of odom, where the robot starts."""
    return (-(p["stiffness"] * x.position[0]), -(p["stiffness"] * x.position[1]), 0.0), z


EFFECT = Effect(
    name="tether_force",
    part="body",
    summary="A force of the tether on the chassis.",
    forms=(
        Form("constant", "tow", constant, tuple(Parameter(axis, "N", 1e-3, -0.05, 0.05, f"force along {axis} of odom") for axis in "xyz")),
        Form("spring", "tow", spring, (Parameter("stiffness", "N/L", 1e-4, 0.0, 0.1, "of the tether"),)),
    ),
    experiment="the same gait away from the tether's end and back",
    source="gap_method 3.2 (tether spring, force)",
    needs=("ground",),
)
