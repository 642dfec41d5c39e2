"""Effects outside: units of the library's dimensions, and factors from inside units to them; HAMR's joints' unless others are given."""

from __future__ import annotations

from collections.abc import Mapping

from hamr_description.units import length_to_si, mass_to_si, time_to_si, torque_to_si

from .law import powers

_UNITS = {"F": "N*m", "Q": "rad", "T": "s", "S": "s", "U": "V", "N": "N", "L": "m", "M": "kg"}
_FACTORS = {
    "F": torque_to_si(1.0), "Q": 1.0, "T": time_to_si(1.0), "S": time_to_si(1.0), "U": 1.0, "N": 1.0, "L": length_to_si(1.0),
    "M": mass_to_si(1.0),
}  # fmt: skip


def si_unit(dimension: str, units: Mapping[str, str] = _UNITS) -> str:
    """Unit of a dimension: "N*m/rad^3" for "F/Q^3"; "1" for a ratio."""
    above = [_power(units[letter], power) for letter, power in powers(dimension) if power > 0]
    below = [_power(units[letter], -power, below=True) for letter, power in powers(dimension) if power < 0]
    return "/".join(["*".join(above) or "1", *below])


def _power(unit: str, power: int, *, below: bool = False) -> str:
    if ("*" in unit or "/" in unit) and (below or power > 1):
        unit = f"({unit})"
    return unit if power == 1 else f"{unit}^{power}"


def si_factor(dimension: str, factors: Mapping[str, float] = _FACTORS) -> float:
    """SI value of one inside unit of a dimension."""
    factor = 1.0
    for letter, power in powers(dimension):
        factor *= factors[letter] ** power
    return factor
