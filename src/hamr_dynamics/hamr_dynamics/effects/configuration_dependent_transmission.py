"""A lever that varies: the actuator's travel is a curved function of the angles, and force and spring act through its slope."""

from __future__ import annotations

from dataclasses import replace

from .law import Effect, Form, Joint, Pair, PairPush, Parameter, Push

POWERS = ((2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3))
SHARE = Parameter("share", "1", 0.7, 0.0, 1.0, "share of the joint's stiffness that is the actuator's", shape=True, screen=(0.2, 0.8))


def lever(x: Joint, p, z):
    """Travel a = q + a2 q^2 + a3 q^3: force a' (drive - k a) in place of drive - k q."""
    bend = x.q * x.q * (p["second"] + p["third"] * x.q)
    slope = x.q * (2.0 * p["second"] + 3.0 * p["third"] * x.q)
    spring = p["share"] * x.stiffness
    force = slope * (x.drive - spring * (x.q + bend)) - spring * bend
    return Push(force, stiffness=spring * (2.0 + slope) * slope, slip=bend), z


def map_of_both(x: Pair, p, z):
    """Travels a_i = q_i + polynomial of both angles: force (da/dq)^T (drive - k a) in place of drive - k q."""
    s, r = x.q
    force, stiffness, slips, net, slopes, springs = [0.0, 0.0], [0.0, 0.0, 0.0], [], [], [], []
    for i in (0, 1):
        c = {power: p[f"a{i + 1}_{power[0]}{power[1]}"] for power in POWERS}
        bend = (
            s * (s * (c[2, 0] + c[3, 0] * s) + r * (c[1, 1] + c[2, 1] * s + c[1, 2] * r)) + r * r * (c[0, 2] + c[0, 3] * r)
        )
        by_s = s * (2.0 * c[2, 0] + 3.0 * c[3, 0] * s + 2.0 * c[2, 1] * r) + r * (c[1, 1] + c[1, 2] * r)
        by_l = r * (2.0 * c[0, 2] + 3.0 * c[0, 3] * r + 2.0 * c[1, 2] * s) + s * (c[1, 1] + c[2, 1] * s)
        spring = p[f"share{i + 1}"] * x.stiffness[i]
        slips.append(bend)
        net.append(x.drive[i] - spring * (x.q[i] + bend))
        slopes.append((by_s, by_l))
        springs.append(spring)
        force[i] = force[i] - spring * bend
    for i in (0, 1):
        for j in (0, 1):
            force[j] = force[j] + slopes[i][j] * net[i]
        full = (slopes[i][0] + (1.0 - i), slopes[i][1] + float(i))
        unit = (1.0 - i, float(i))
        for e, (j, k) in enumerate(((0, 0), (0, 1), (1, 1))):
            stiffness[e] = stiffness[e] + springs[i] * (full[j] * full[k] - unit[j] * unit[k])
    return PairPush(tuple(force), stiffness=tuple(stiffness), slip=tuple(slips)), z


def _coefficient(i: int, a: int, b: int) -> Parameter:
    return Parameter(f"a{i}_{a}{b}", f"1/Q^{a + b - 1}", 0.02, -3.0, 3.0, f"travel of actuator {i} per swing^{a} lift^{b}")


EFFECT = Effect(
    name="configuration_dependent_transmission",
    part="transmission",
    summary="A lever between actuator and joint that varies with the angles; the actuator's force and spring both act through it.",
    forms=(
        Form("lever", "force", lever, (
            Parameter("second", "1/Q", 0.03, -3.0, 3.0, "travel per squared angle"),
            Parameter("third", "1/Q^2", 0.03, -3.0, 3.0, "travel per cubed angle"),
            SHARE,
        )),
        Form("map", "pair", map_of_both, (
            *(_coefficient(i, a, b) for i in (1, 2) for a, b in POWERS),
            *(replace(SHARE, name=f"share{i}", screen=(0.7,)) for i in (1, 2)),
        )),
    ),
    experiment="large motions of both joints; actuator deflection and joint angle side by side",
    source="hamr_facts 7, effect 8 (ratio +40..49 % over the stroke)",
)  # fmt: skip
