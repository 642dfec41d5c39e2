"""A machine's sizes and sensor channels in SI."""

from __future__ import annotations

from hamr_description.names import ACTUATORS
from hamr_description.units import length_to_si
from hamr_dynamics.effects.si import si_factor, si_unit
from hamr_dynamics.machine import Machine


def si_of(dimension: str, machine: Machine) -> tuple[float, str]:
    """Factor to SI and unit of a dimension such as "F*T/Q": (1e-6, "N*m*s/rad") on HAMR's legs."""
    to_si, units = ({**own, "S": own["T"]} for own in (machine.to_si, machine.units))
    return si_factor(dimension, to_si), si_unit(dimension, units)


def channel_si(machine: Machine, channel: str) -> tuple[float, str]:
    """Factor to SI and unit of a sensor channel: the joints' motion, or an actuator's tip."""
    return (length_to_si(1.0), "m") if channel in ACTUATORS else si_of(dimension_of(machine, channel), machine)


def dimension_of(machine: Machine, channel: str) -> str:
    """"Q" of a coordinate, "Q/T" of a rate, "Q/T^2" of an acceleration."""
    return ("Q", "Q/T", "Q/T^2")[(machine.motion_of(channel) or (0, 0))[1]]
