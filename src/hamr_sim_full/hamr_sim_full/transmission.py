"""Kinematics of the spherical five-bar transmission in closed form, from the two hip angles.

Two chains drive the leg link L4 (hamr_facts, REPO): swing  slider -> S1 -s1- S2 -s2- S3 -fb1- S4, lift
slider -> L1 -l1- L2 -l2- L3 -fb3- L4, with S4 and L4 sharing their y axis. All spherical axes meet at the hip centre:
`Rz(psi) Rx(alpha) e_y = Rx(lift) Rz(swing) e_y` gives the yaw psi of S3 and the roll alpha of S4; each input is a planar
slider-crank. Nothing is iterated and no loop can drift.
"""

from __future__ import annotations

from dataclasses import dataclass

from hamr_dynamics import jet
from hamr_dynamics.jet import Jet


@dataclass(frozen=True, slots=True)
class Turn:
    """An angle as sine, cosine and the angle itself (jets)."""

    sin: Jet
    cos: Jet
    angle: Jet


@dataclass(frozen=True, slots=True)
class Transmission:
    """All link poses of one leg, front-left frame.

    Attributes:
        swing, lift: hip angles. psi: yaw of S3. alpha: roll of S4 in S3. sigma: yaw of S2. lam: roll of L2.
        s2, l2: origins of S3 and L3 (hinges s2 and l2), three jets, mm.
        tips: deflections of the swing and lift sliders, mm.
    """

    swing: Turn
    lift: Turn
    psi: Turn
    alpha: Turn
    sigma: Turn
    lam: Turn
    s2: tuple
    l2: tuple
    tips: tuple[Jet, Jet]


def _turn(s: Jet, c: Jet) -> Turn:
    return Turn(s, c, jet.angle(s, c))


def solve(q, p) -> Transmission:
    """Pose of every link.

    Args:
        q: (2,) swing and lift angle, rad.
        p: parameters (`parameters.leg_parameters`): geometry in mm.
    """
    beta, phi = jet.variables(q)
    (sb, cb), (sp, cp) = jet.sincos(beta), jet.sincos(phi)
    sa = sp * cb
    ca = jet.sqrt(1.0 - sa * sa)
    inverse = jet.reciprocal(ca)
    alpha, psi = _turn(sa, ca), _turn(sb * inverse, cp * cb * inverse)

    hip, s3, l3 = p["hip"], p["s3_in_S3"], p["l3_in_L3"]
    s2 = (hip[0] - (psi.cos * s3[0] - psi.sin * s3[1]), hip[1] - (psi.sin * s3[0] + psi.cos * s3[1]), Jet(p["s2_height"]))
    sigma, swing_tip = _slider_crank(-(s2[0] - p["s1_x"]), s2[1], p["swing_coupler"], p["s1_y"])
    l2 = (Jet(p["l2_x"]), hip[1] - (cp * l3[1] - sp * l3[2]), hip[2] - (sp * l3[1] + cp * l3[2]))
    lam, lift_tip = _slider_crank(l2[2] - p["l1_z"], l2[1], p["lift_coupler"], p["l1_y"])
    return Transmission(Turn(sb, cb, beta), Turn(sp, cp, phi), psi, alpha, sigma, lam, s2, l2, (swing_tip, lift_tip))


def _slider_crank(offset: Jet, end: Jet, coupler, origin) -> tuple[Turn, Jet]:
    """Coupler angle and slider position of a planar slider-crank.

    `offset` is the crank end's distance across the slider axis (sign of the coupler angle), `end` its position along it,
    `origin` where the coupler's other end lies at slider zero. All mm.
    """
    s = offset * (1.0 / coupler)
    c = jet.sqrt(1.0 - s * s)
    return _turn(s, c), end - c * coupler - origin


def foot(t: Transmission, p):
    """Foot in the chassis frame: three jets, mm."""
    return on_l4(t, p, p["foot_in_L4"])


def on_s2(t: Transmission, p, point):
    """A point of S2 in the chassis frame."""
    x, y, z = point
    s, c = t.sigma.sin, t.sigma.cos
    return p["s1_x"] + (c * x - s * y), t.tips[0] + p["s1_y"] + (s * x + c * y), Jet(p["s1_z"] + z)


def on_l2(t: Transmission, p, point):
    """A point of L2 in the chassis frame."""
    x, y, z = point
    s, c = t.lam.sin, t.lam.cos
    return Jet(p["l2_x"] + x), t.tips[1] + p["l1_y"] + (c * y - s * z), p["l1_z"] + (s * y + c * z)


def on_l3(t: Transmission, point):
    """A point of L3 (coordinates numbers or jets) in the chassis frame."""
    x, y, z = point
    s, c = t.lift.sin, t.lift.cos
    return t.l2[0] + x, t.l2[1] + (c * y - s * z), t.l2[2] + (s * y + c * z)


def on_l4(t: Transmission, p, point):
    """A point of L4 in the chassis frame."""
    x, y, z = point
    s, c = t.swing.sin, t.swing.cos
    return on_l3(t, tuple(o + r for o, r in zip(p["fb3"], (c * x - s * y, s * x + c * y, z), strict=True)))


def on_s3(t: Transmission, point):
    """A point of S3 (coordinates numbers or jets) in the chassis frame."""
    x, y, z = point
    s, c = t.psi.sin, t.psi.cos
    return t.s2[0] + (c * x - s * y), t.s2[1] + (s * x + c * y), t.s2[2] + z


def on_s4(t: Transmission, p, point):
    """A point of S4 in the chassis frame."""
    x, y, z = point
    s, c = t.alpha.sin, t.alpha.cos
    return on_s3(t, tuple(o + r for o, r in zip(p["fb1"], (x, c * y - s * z, s * y + c * z), strict=True)))


def rotations(t: Transmission):
    """Rotation matrices (rows of numbers, not jets) of S2, S3, S4, L2, L3, L4."""

    def rz(a):
        return ((a.cos.value, -a.sin.value, 0.0), (a.sin.value, a.cos.value, 0.0), (0.0, 0.0, 1.0))

    def rx(a):
        return ((1.0, 0.0, 0.0), (0.0, a.cos.value, -a.sin.value), (0.0, a.sin.value, a.cos.value))

    def times(a, b):
        return tuple(tuple(sum((a[i][k] * b[k][j] for k in range(3)), 0.0) for j in range(3)) for i in range(3))

    s3, l3 = rz(t.psi), rx(t.lift)
    return {
        "S2": rz(t.sigma), "S3": s3, "S4": times(s3, rx(t.alpha)),
        "L2": rx(t.lam), "L3": l3, "L4": times(l3, rz(t.swing)),
    }  # fmt: skip


def closure_gap(t: Transmission, p) -> tuple:
    """Distances (mm) that the third loop closure leaves open along S4's x and z: exactly zero in theory."""
    a, b = on_s4(t, p, p["fb2_in_S4"]), on_l4(t, p, p["fb2_in_L4"])
    gap = tuple(x.value - y.value for x, y in zip(a, b, strict=True))
    s4 = rotations(t)["S4"]
    return tuple(sum((s4[i][k] * gap[i] for i in range(3)), 0.0) for k in (0, 2))


def flexure_angles(t: Transmission) -> dict[str, Jet]:
    """Angle of each sprung flexure (jets, rad)."""
    return {
        "s1": t.sigma.angle, "s2": t.psi.angle - t.sigma.angle, "fb1": t.alpha.angle,
        "l1": t.lam.angle, "l2": t.lift.angle - t.lam.angle, "fb3": t.swing.angle,
    }  # fmt: skip

