"""What a drive gives varies with the angles: through a lever, that the spring acts through too, or by the actuator's own force."""

from __future__ import annotations

from dataclasses import replace

from .law import Effect, Form, Joint, Pair, PairPush, Parameter, Push

POWERS, FINE = (tuple((n - j, j) for n in range(2, degree + 1) for j in range(n + 1)) for degree in (3, 5))
SHARE = Parameter("share", "1", 0.7, 0.0, 1.0, "share of the joint's stiffness that is the actuator's", shape=True, screen=(0.2, 0.8))
SHARES = tuple(replace(SHARE, name=f"share{i}", screen=(0.7,)) for i in (1, 2))


def lever(x: Joint, p, z):
    """Travel a = q + a2 q^2 + a3 q^3: force a' (drive - k a) in place of drive - k q."""
    bend = x.q * x.q * (p["second"] + p["third"] * x.q)
    slope = x.q * (2.0 * p["second"] + 3.0 * p["third"] * x.q)
    spring = p["share"] * x.stiffness
    force = slope * (x.drive - spring * (x.q + bend)) - spring * bend
    return Push(force, stiffness=spring * (2.0 + slope) * slope, slip=bend), z


def force_factor(x: Joint, p, z):
    """Force drive (1 + b1 q + b2 q^2): the actuator gives more or less per volt where it is bent; travels are as they were."""
    return Push(x.drive * (x.q * (p["first"] + p["second"] * x.q))), z


def map_of_both(x: Pair, p, z):
    """Travels a_i = q_i + polynomial of both angles: force (da/dq)^T (drive - k a) in place of drive - k q."""
    return _through(x, p, POWERS), z


def fine_map(x: Pair, p, z):
    """The same up to the fifth degree, for travels as large as a linkage has them near its end stops."""
    return _through(x, p, FINE), z


def _through(x: Pair, p, powers: tuple[tuple[int, int], ...]) -> PairPush:
    """Drives and springs through travels with terms s^i l^j of some powers (i, j)."""
    (s, r), most = x.q, powers[-1][1]
    of_s, of_r = ([1.0], [1.0])
    for _ in range(most):
        of_s.append(of_s[-1] * s)
        of_r.append(of_r[-1] * r)
    force, stiffness, slips, net, slopes, springs = [0.0, 0.0], [0.0, 0.0, 0.0], [], [], [], []
    for i in (0, 1):
        bend, by_s, by_l = 0.0, 0.0, 0.0
        for a, b in powers:
            c = p[f"a{i + 1}_{a}{b}"]
            bend = bend + c * (of_s[a] * of_r[b])
            by_s = by_s + c * (float(a) * of_s[max(a - 1, 0)] * of_r[b])
            by_l = by_l + c * (float(b) * of_r[max(b - 1, 0)] * of_s[a])
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
    return PairPush(tuple(force), stiffness=tuple(stiffness), slip=tuple(slips))


def _coefficient(i: int, a: int, b: int) -> Parameter:
    return Parameter(f"a{i}_{a}{b}", f"1/Q^{a + b - 1}", 0.02, -3.0, 3.0, f"travel of actuator {i} per swing^{a} lift^{b}")


EFFECT = Effect(
    name="configuration_dependent_transmission",
    part="transmission",
    summary="A lever between actuator and joint, or the actuator's force itself, that varies with the angles.",
    forms=(
        Form("lever", "force", lever, (
            Parameter("second", "1/Q", 0.03, -3.0, 3.0, "travel per squared angle"),
            Parameter("third", "1/Q^2", 0.03, -3.0, 3.0, "travel per cubed angle"),
            SHARE,
        )),
        Form("force_factor", "force", force_factor, (
            Parameter("first", "1/Q", 0.03, -3.0, 3.0, "relative force per angle"),
            Parameter("second", "1/Q^2", 0.03, -3.0, 3.0, "relative force per squared angle"),
        )),
        Form("map", "pair", map_of_both, (
            *(_coefficient(i, a, b) for i in (1, 2) for a, b in POWERS), *SHARES,
        )),
        Form("fine_map", "pair", fine_map, (
            *(_coefficient(i, a, b) for i in (1, 2) for a, b in FINE), *SHARES,
        )),
    ),
    experiment="large motions of both joints; actuator deflection and joint angle side by side",
    source="hamr_facts 7, effects 8 (ratio +40..49 % over the stroke) and 10 (deflection-dependent actuator force)",
)  # fmt: skip
