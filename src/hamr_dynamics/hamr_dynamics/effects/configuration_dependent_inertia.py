"""Inertia that depends on where the leg is, with the velocity forces that belong to it."""

from __future__ import annotations

from .law import Effect, Form, Joint, Pair, PairPush, Parameter, Push

ENTRIES = ((0, 0), (0, 1), (1, 1))
POWERS = ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2))


def polynomial(x: Pair, p, z):
    """M(q) = sum of coefficients times s, l, s^2, s l, l^2 in each entry; velocity forces from its Christoffel symbols."""
    (s, r), (vs, vl) = x.q, x.v
    values, slopes = [], []
    for i, j in ENTRIES:
        c = [p[f"m{i + 1}{j + 1}_{a}{b}"] for a, b in POWERS]
        values.append(c[0] * s + c[1] * r + c[2] * s * s + c[3] * s * r + c[4] * r * r)
        slopes.append((c[0] + 2.0 * c[2] * s + c[3] * r, c[1] + c[3] * s + 2.0 * c[4] * r))
    (m11s, m11l), (m12s, m12l), (m22s, m22l) = slopes
    # bias_i = sum_jk (d_k M_ij - d_i M_jk / 2) v_j v_k
    swing = 0.5 * m11s * vs * vs + m11l * vs * vl + (m12l - 0.5 * m22s) * vl * vl
    lift = 0.5 * m22l * vl * vl + m22s * vs * vl + (m12s - 0.5 * m11l) * vs * vs
    d12 = (m12l - 0.5 * m22s) * vl + (m12s - 0.5 * m11l) * vs + 0.5 * (m11l * vs + m22s * vl)
    return PairPush((-swing, -lift), mass=tuple(values), damping=(m11s * vs + m11l * vl, d12, m22l * vl + m22s * vs)), z


def own(x: Joint, p, z):
    """m1 q + m2 q^2, with half its rate of change as damping."""
    mass = x.q * (p["slope"] + p["curvature"] * x.q)
    rate = (p["slope"] + 2.0 * p["curvature"] * x.q) * x.v
    return Push(-(0.5 * rate * x.v), damping=rate, mass=mass), z


def _entry(i: int, j: int, a: int, b: int) -> Parameter:
    name = f"m{i + 1}{j + 1}_{a}{b}"
    return Parameter(name, f"F*T^2/Q^{a + b + 1}", 0.02, -3.0, 3.0, f"inertia {i + 1}{j + 1} per swing^{a} lift^{b}")


EFFECT = Effect(
    name="configuration_dependent_inertia",
    part="body",
    summary="A mass matrix that changes with the angles, together with the velocity forces that this brings.",
    forms=(
        Form("own", "force", own, (
            Parameter("slope", "F*T^2/Q^2", 0.02, -3.0, 3.0, "change of a joint's inertia per its angle"),
            Parameter("curvature", "F*T^2/Q^3", 0.02, -3.0, 3.0, "change per squared angle"),
        )),
        Form("polynomial", "pair", polynomial, tuple(_entry(*entry, *power) for entry in ENTRIES for power in POWERS)),
    ),
    experiment="large motions of both joints, faster than the resonance",
    source="hamr_facts 7, effect 7; Gruenstein et al.",
    mimics=("lift_swing_coupling",),  # its inertia, where all else is made lighter instead
)  # fmt: skip
