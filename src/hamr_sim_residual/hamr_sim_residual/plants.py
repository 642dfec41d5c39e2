"""HAMR-simple and the published lumped fit as registered plants."""

from __future__ import annotations

from hamr_description.numbers import value
from hamr_description.simple_constants import simple_constants
from hamr_dynamics.plant import Plant, register

from .simple import simple_leg, simple_parameters
from .simple_published import published_leg, published_parameters

TUNABLE = ("mass", "com", "inertia", "stiffness", "damping", "torque_per_volt", "stop_low", "stop_high", "stop_stiffness", "stop_damping")


def simple() -> Plant:
    """HAMR-simple, equal to HAMR-full to first order."""
    return Plant("simple", simple_leg, simple_parameters, simple_constants()["chassis"], TUNABLE)


def simple_published() -> Plant:
    """The published lumped fit."""
    chassis = {key: value(f"chassis.{key}") for key in ("mass", "com", "inertia")}
    return Plant("simple_published", published_leg, published_parameters, chassis, TUNABLE)


register("simple", simple)
register("simple_published", simple_published)
