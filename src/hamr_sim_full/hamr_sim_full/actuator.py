"""Piezo bender: constants of its force law from geometry and material (REPO, after Jafferis 2015).

With tip deflection q, orientation s = +-1, bias rail Vb, ground Vg and drive voltage V the tip force is

    F(V, q) = s [ (c0 - s c1 q) (Vb - V) - (c0 + s c1 q) (V - Vg) ] = s c0 (Vb + Vg - 2 V) - c1 (Vb - Vg) q

so a fixed bias rail acts like a spring c1 (Vb - Vg) beside the passive bending stiffness k.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

from hamr_description.numbers import value


@dataclass(frozen=True, slots=True)
class Bender:
    """Constants of the force law.

    Attributes:
        geometry_factor: GF of a tapered bender with a stiff extension, 1.
        c0: force per volt of one layer at rest, N/V.
        c1: change of c0 with deflection, N/(V mm).
        stiffness: passive bending stiffness at the tip, N/mm.
        rail_stiffness: stiffness added by the bias rail, N/mm.
        blocked_force: force at full drive and no deflection, N.
        free_deflection: deflection at which f31 reaches its free value, mm.
    """

    geometry_factor: float
    c0: float
    c1: float
    stiffness: float
    rail_stiffness: float
    blocked_force: float
    free_deflection: float


@cache
def bender() -> Bender:
    """The bender of numbers.yaml, group `actuator`."""

    def a(name: str) -> float:
        return value(f"actuator.{name}")

    rail = a("bias_voltage") - a("ground_voltage")
    pzt, core, length, width, taper = a("pzt_thickness"), a("core_thickness"), a("length"), a("width"), a("width_ratio")
    blocked, free = a("f31_blocked"), a("f31_free")
    r = a("extension") / length
    geometry = (8 * (1 - taper) ** 3 * (1 + 2 * r)) / (
        -6 * (taper - 1) * (-3 + 4 * r * (taper - 1) + 2 * taper)
        + 3 * (-2 + 2 * r * (taper - 1) + taper) ** 2 * math.log((2 - taper) / taper)
    )
    rigidity = (
        a("pzt_modulus") * pzt * (1.5 * core**2 + 3 * core * pzt + 2 * pzt**2) / 3 + a("core_modulus") * core**3 / 12
    )  # N mm, per width
    deflection = 0.25 * (1 + 2 * r) * free * pzt * length**2 * (rail / pzt) * (pzt + core) / rigidity
    per_f31 = 0.75 * width * (pzt + core) * geometry / length
    c0, c1 = per_f31 * blocked, per_f31 * (free - blocked) / deflection
    return Bender(
        geometry_factor=geometry,
        c0=c0,
        c1=c1,
        stiffness=3 * (blocked / free) * (width / length**3) * geometry * rigidity / (1 + 2 * r),
        rail_stiffness=c1 * rail,
        blocked_force=c0 * rail,
        free_deflection=deflection,
    )
