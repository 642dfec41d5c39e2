"""HAMR-full as a registered plant."""

from __future__ import annotations

from functools import partial

from hamr_description.numbers import value
from hamr_dynamics.plant import Plant, register

from .leg import full_leg
from .parameters import FLEXURES, leg_parameters

TUNABLE = (
    *(f"{kind}_{flexure}" for flexure in FLEXURES for kind in "kb"),
    "drive_force", "drive_spring", "tip_stiffness", "tip_damping", "stop", "stop_stiffness", "stop_damping",
)  # fmt: skip


def full(*, rail: bool = True) -> Plant:
    """HAMR-full with the published numbers; without the bias rail's spring for `rail=False`."""
    chassis = {key: value(f"chassis.{key}") for key in ("mass", "com", "inertia")}
    return Plant("full", full_leg, partial(leg_parameters, rail=rail), chassis, TUNABLE)


register("full", full)
