"""Dimensions of effects in SI."""

from __future__ import annotations

import re
from collections.abc import Mapping

from hamr_dynamics.effects.law import Scales


def si_of(dimension: str, to_si: Mapping[str, float], units: Mapping[str, str]) -> tuple[float, str]:
    """Factor to SI and the unit's name of a dimension such as "F*T/Q": (1e-6, "N*m*s/rad") on HAMR's legs."""
    factor = Scales(to_si["F"], to_si["Q"], to_si["T"], to_si["U"]).of(dimension)
    unit = re.sub(r"[FQTU]", lambda match: units[match[0]], dimension)
    return factor, "1" if unit == "1" else unit.removeprefix("1*")
