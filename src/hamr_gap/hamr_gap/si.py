"""Dimensions of effects in SI."""

from __future__ import annotations

import re
from collections.abc import Mapping

from hamr_description.names import ACTUATORS
from hamr_description.units import length_to_si
from hamr_dynamics.effects.law import Scales
from hamr_dynamics.machine import Machine


def si_of(dimension: str, to_si: Mapping[str, float], units: Mapping[str, str]) -> tuple[float, str]:
    """Factor to SI and the unit's name of a dimension such as "F*T/Q": (1e-6, "N*m*s/rad") on HAMR's legs."""
    factor = Scales(to_si["F"], to_si["Q"], to_si["T"], to_si["U"]).of(dimension)
    unit = re.sub(r"[FQTU]", lambda match: units[match[0]], dimension)
    return factor, "1" if unit == "1" else unit.removeprefix("1*")


def channel_si(machine: Machine, channel: str) -> tuple[float, str]:
    """Factor to SI and unit of a sensor channel: the joints' own, or an actuator's tip."""
    return (length_to_si(1.0), "m") if channel in ACTUATORS else (machine.to_si["Q"], machine.units["Q"])
