"""`hamr check`: every published fact about the robot beside this model's value.

References are those of hamr_facts: P from a publication or its model files, D derived from published numbers by an
independent calculation. A row that is off is shown as off. `known` marks those whose reason is known and stands beside them: gaps
between the published model and the real robot, which this project reproduces on purpose; they do not decide the verdict.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass

import numpy as np

from hamr_description.names import LEGS
from hamr_description.numbers import number, value
from hamr_description.posture import neutral_foot
from hamr_description.rates import SERVO_MS
from hamr_description.simple_constants import simple_constants
from hamr_dynamics import contact

from . import transmission
from .actuator import bender
from .parameters import LINKS, leg_parameters
from .reduced import hip_angles, reduce
from .sag import static_sag

CALC = "D, from REPO numbers"


@dataclass(frozen=True, slots=True)
class Row:
    """A fact: the model's value, the reference, the relative or absolute tolerance, and under which condition both hold."""

    name: str
    value: float
    unit: str
    reference: float | None
    tolerance: float
    ok: bool
    source: str
    condition: str = ""
    known: bool = False


def within(name, measured, unit, reference, relative, source, condition="", *, known=False) -> Row:
    """A row with a relative tolerance."""
    tolerance = abs(reference) * relative
    return Row(name, float(measured), unit, reference, tolerance, bool(abs(measured - reference) <= tolerance), source, condition, known)


def near(name, measured, unit, reference, tolerance, source, condition="") -> Row:
    """A row with an absolute tolerance."""
    return Row(name, float(measured), unit, reference, tolerance, bool(abs(measured - reference) <= tolerance), source, condition)


def rows() -> list[dict]:
    """All rows, in the order of hamr_facts. The settling runs take a few seconds."""
    parts = (_body, _geometry, _ratios, _sweep, _reduced, _stroke, _modes, _actuator, _statics, _simple, _contact, _settled)
    return [asdict(row) for part in parts for row in part()]


def check() -> dict:
    """What `hamr check` prints: {ok, rows}."""
    table = rows()
    return {"ok": all(row["ok"] or row["known"] for row in table), "rows": table}


def _body() -> Iterator[Row]:
    links = sum(leg_parameters(leg)[f"mass_{link}"] for leg in LEGS for link in LINKS)
    total = value("chassis.mass") + links
    yield near("mass", total, "g", 1.47499, 1e-5, CALC, "sum of the published links")
    yield near("mass, published total", total, "g", 1.465, 0.036, "P, SEED 1.43 to IJRR19 1.5", "sources differ by 5 %")
    yield within("transmission mass, front", sum(leg_parameters("fl")[f"mass_{k}"] for k in LINKS), "g", 0.0676, 1e-3, CALC)
    yield within("transmission mass, rear", sum(leg_parameters("rl")[f"mass_{k}"] for k in LINKS), "g", 0.0666, 1e-3, CALC)
    clearance = -neutral_foot("fl")[2] + value("robot.chassis_z_range")[0]
    yield near("under-body clearance", clearance, "mm", 4.3, 0.05, CALC, "neutral")


def _geometry() -> Iterator[Row]:
    p = leg_parameters("fl")
    for axis, reference in zip("xyz", (12.75465981539, 9.79, 0.46), strict=True):
        yield near(f"hip centre {axis}", p["hip"]["xyz".index(axis)], "mm", reference, 1e-4, "P, REPO", "front left")
    foot = reduce().foot
    for axis, x, reference in zip("xyz", foot, (12.75466, 17.37, -12.54), strict=True):
        yield near(f"neutral foot {axis}", x, "mm", reference, 1e-4, CALC, "front left, chassis frame")
    gap = max(abs(g) for g in transmission.closure_gap(transmission.solve((0.0, 0.0), p), p))
    yield near("loop residual", gap, "mm", 0.0, 1e-5, "P, REPO geometry", "at rest")
    reach = [(x, y) for x in (-0.3, 0.0, 0.3) for y in (-0.3, 0.0, 0.3)]
    poses = [transmission.solve(tuple(hip_angles(tips, p)), p) for tips in reach]
    gap = max(abs(g) for t in poses for g in transmission.closure_gap(t, p))
    yield near("loop residual over the stroke", gap, "mm", 0.0, 1e-5, "P, REPO geometry", "tips +-0.3 mm")
    radius = max(abs(np.linalg.norm([c.value for c in transmission.foot(t, p)] - np.array(p["hip"])) - 15.05) for t in poses)
    yield near("foot sphere radius error", radius, "mm", 0.0, 5e-3, CALC, "15.05 mm about the hip, tips +-0.3 mm")


def _ratios() -> Iterator[Row]:
    r = reduce()
    for angle, column, reference in (
        ("s2", 0, 1.91722),
        ("l2", 1, 1.83051),
        ("fb3", 0, 1.88679),
        ("fb1", 1, 1.72414),
        ("s1", 0, -0.03042),
        ("l1", 1, -0.10637),
    ):
        yield within(f"transmission ratio {angle}", r.ratios[angle][column], "rad/mm", reference, 1e-3, CALC, "front left, at rest")
    for axis, column, reference in (("x", 0, -14.3019), ("z", 1, 13.069), ("y", 1, 22.4138)):
        drive = ("swing", "lift")[column]
        yield within(
            f"foot {axis} per {drive} tip", r.foot_ratio["xyz".index(axis), column], "mm/mm", reference, 1e-3, CALC, "front left, at rest"
        )


def _sweep() -> Iterator[Row]:
    rest = reduce().foot
    published = {
        (0.2, 0): ("s2", 21.3, {"x": -2.74, "y": -0.5}),
        (-0.2, 0): ("s2", -24.1, {"x": 3.01, "y": -0.6}),
        (0.3, 0): ("s2", 32.0, {"x": -4.03}),
        (-0.3, 0): ("s2", -39.7, {"x": 4.69}),
        (0, 0.2): ("l2", 19.7, {"z": 3.27, "y": 3.9}),
        (0, -0.2): ("l2", -23.7, {"z": -1.86, "y": -5.2}),
        (0, 0.3): ("l2", 28.9, {"z": 5.39}),
        (0, -0.3): ("l2", -39.5, {"z": -2.01}),
    }
    for tips, (angle, degrees, feet) in published.items():
        r, condition = reduce(tips), f"tips at {tips[0]:+g}, {tips[1]:+g} mm"
        yield near(f"sweep {angle}", np.degrees(r.angles[angle]), "deg", degrees, 0.06, CALC, condition)
        for axis, reference in feet.items():
            digits = 0.06 if round(reference, 1) == reference else 0.006
            yield near(f"foot d{axis}", (r.foot - rest)["xyz".index(axis)], "mm", reference, digits, CALC, condition)


def _reduced() -> Iterator[Row]:
    r, condition = reduce(rail=False), "tip coordinates, at rest, rail off"
    for name, measured, unit, reference in (
        ("M11", r.mass[0, 0], "g", 3.68471),
        ("M12", r.mass[0, 1], "g", -1.30182),
        ("M22", r.mass[1, 1], "g", 5.76876),
        ("K11", r.stiffness[0, 0], "N/mm", 1.4017),
        ("K22", r.stiffness[1, 1], "N/mm", 1.45015),
        ("D11", r.damping[0, 0], "N ms/mm", 0.129922),
        ("D22", r.damping[1, 1], "N ms/mm", 0.123139),
    ):
        yield within(f"reduced {name}", measured, unit, reference, 1e-3, CALC, condition)
    correlation = r.mass[0, 1] / np.sqrt(r.mass[0, 0] * r.mass[1, 1])
    yield near("inertial coupling", correlation, "1", -0.28, 0.005, CALC, condition)


def _stroke() -> Iterator[Row]:
    for tips, name, pick, unit, reference in (
        ((-0.25, 0), "M11", lambda r: r.mass[0, 0], "g", 6.7917),
        ((0.25, 0), "M22", lambda r: r.mass[1, 1], "g", 4.9106),
        ((0, -0.25), "M22", lambda r: r.mass[1, 1], "g", 10.1915),
        ((0, 0.25), "M11", lambda r: r.mass[0, 0], "g", 3.1459),
        ((-0.25, 0), "K11", lambda r: r.stiffness[0, 0], "N/mm", 1.6264),
        ((0, -0.25), "K22", lambda r: r.stiffness[1, 1], "N/mm", 1.7638),
        ((-0.25, 0), "ratio s2", lambda r: r.ratios["s2"][0], "rad/mm", 2.6903),
        ((0.25, 0), "ratio s2", lambda r: r.ratios["s2"][0], "rad/mm", 1.862),
        ((0, -0.25), "ratio l2", lambda r: r.ratios["l2"][1], "rad/mm", 2.7334),
        ((0, 0.25), "ratio l2", lambda r: r.ratios["l2"][1], "rad/mm", 1.6145),
    ):
        yield within(
            f"{name} over the stroke", pick(reduce(tips, rail=False)), unit, reference, 1e-3, CALC, f"tips at {tips[0]:+g}, {tips[1]:+g} mm"
        )


def _modes() -> Iterator[Row]:
    for rail, references in ((False, ((75.54, 24.4), (108.09, 16.2))), (True, ((85.05, 27.4), (121.95, 18.2)))):
        condition = f"rail {'on' if rail else 'off'}, front left, in air"
        for axis, (hz, quality), reference in zip(("lift", "swing"), reduce(rail=rail).modes(), references, strict=True):
            yield within(f"{axis} mode", hz, "Hz", reference[0], 0.01, CALC, condition)
            yield within(f"{axis} quality factor", quality, "1", reference[1], 0.01, CALC, condition)
    lift, swing = reduce(rail=True).modes()
    source = "P, REPO, identified from its simulator"
    yield near("lift mode, identified", lift[0], "Hz", 84.85, 0.46, source, "rail on; published 84.4 to 85.3")
    yield near("swing mode, identified", swing[0], "Hz", 123.0, 2.0, source, "rail on; published 121 to 125")
    known = {"known": True, "condition": "a real leg is damped more (effect 2 of hamr_facts section 7)"}
    yield within("lift quality factor, robot", reduce(rail=False).modes()[0][1], "1", 10.3, 0.32, "P, ICRA17, n = 4", **known)
    yield within("swing quality factor, robot", reduce(rail=False).modes()[1][1], "1", 9.6, 0.16, "P, ICRA17, n = 4", **known)


def _actuator() -> Iterator[Row]:
    law = bender()
    for name, measured, unit, reference, relative in (
        ("geometry factor", law.geometry_factor, "1", 1.0524, 1e-4),
        ("force per volt c0", law.c0, "N/V", 1.4413e-3, 1e-4),
        ("deflection term c1", law.c1, "N/(V mm)", 1.712e-3, 1e-4),
        ("free deflection", law.free_deflection, "mm", 0.2806, 1e-3),
        ("bias stiffness", law.rail_stiffness, "N/mm", 0.385189, 1e-3),
    ):
        yield within(name, measured, unit, reference, relative, CALC)
    yield within("blocked force", law.blocked_force, "N", 0.3243, 1e-3, CALC, "V = 0 or 225, no deflection")
    yield within(
        "actuator stiffness", law.stiffness, "N/mm", value("actuator.stiffness"), 1e-3, "P, REPO", "bender formula against the model file"
    )


def _statics() -> Iterator[Row]:
    on, off, p = reduce(rail=True), reduce(rail=False), leg_parameters("fl")
    gain = 1e3 * p["drive_force"] / np.diag(on.stiffness)
    for axis, measured, derived, published in zip(("swing", "lift"), gain, (1.613, 1.571), (1.62, 1.59), strict=True):
        yield within(f"{axis} DC gain", measured, "um/V", derived, 0.005, CALC, "rail on")
        yield within(f"{axis} DC gain, identified", measured, "um/V", published, 0.02, "P, REPO", "rail on")
    travel = gain * 1e-3 * value("actuator.neutral_voltage")
    yield within("static travel swing", travel[0], "mm", 0.181, 0.005, CALC, "0 to 225 V, linearised")
    yield within("static travel lift", travel[1], "mm", 0.177, 0.005, CALC, "0 to 225 V, linearised")
    k_x, k_z = 1e3 * np.diag(off.stiffness) / np.array([off.foot_ratio[0, 0], off.foot_ratio[2, 1]]) ** 2
    yield within("foot stiffness x", k_x, "N/m", 6.85, 0.005, CALC, "rail off")
    yield within("foot stiffness z", k_z, "N/m", 8.49, 0.005, CALC, "rail off")
    yield within("foot stiffness x, published", k_x, "N/m", 6.853, 0.01, "P, REPO map", "rail off")
    yield within("foot stiffness z, published", k_z, "N/m", 8.688, 0.03, "P, REPO map", "rail off")
    mass = value("chassis.mass") + sum(leg_parameters(leg)[f"mass_{link}"] for leg in LEGS for link in LINKS)
    weight = mass * value("robot.gravity")
    yield within("static sag, linear", 1e3 * weight / (4.0 * k_z), "mm", 0.43, 0.02, CALC, "rail off, no friction")
    heave = 1e3 * np.sqrt(4e-3 * k_z / mass) / (2 * np.pi)
    yield within("heave resonance", heave, "Hz", 24.15, 0.005, CALC, "rail off, feet free sideways")
    reason = "the largest published gap between model and robot (serial compliance)"
    yield within("heave resonance, robot", heave, "Hz", 10.0, 0.1, "P, IJRR19 citing G17a", reason, known=True)
    force = 1e3 * bender().blocked_force / off.foot_ratio[2, 1]
    yield within("largest static foot force up", force, "mN", 24.8, 0.005, CALC, "at rest, one leg")


def _simple() -> Iterator[Row]:
    front, condition = simple_constants()["front"], "HAMR-simple, front left, per hip angle at rest"
    com, m = np.array(front["com"]), front["mass"]
    xx, yy, zz, xy, xz, yz = front["inertia"]
    about_hip = {
        "M11": zz + m * (com[0] ** 2 + com[1] ** 2),
        "M12": xz - m * com[0] * com[2],
        "M22": xx + m * (com[1] ** 2 + com[2] ** 2),
        "Iyy": yy + m * (com[0] ** 2 + com[2] ** 2),
        "|Ixy|": abs(xy - m * com[0] * com[1]),
        "|Iyz|": abs(yz - m * com[1] * com[2]),
    }
    for name, reference, relative in (
        ("M11", 1.0350, 1e-3),
        ("M12", -0.4002, 1e-3),
        ("M22", 1.9406, 1e-3),
        ("Iyy", 1.22, 0.01),
        ("|Ixy|", 0.18, 0.03),
        ("|Iyz|", 0.38, 0.02),
    ):
        yield within(f"simple {name}", about_hip[name], "g mm^2", reference, relative, "D, design", condition)
    for i, axis in enumerate(("swing", "lift")):
        for name, key, unit, reference in (
            ("stiffness", "stiffness", "N mm/rad", (0.5019, 0.6173)[i]),
            ("damping", "damping", "N mm ms/rad", (0.03650, 0.04142)[i]),
            ("torque per volt", "torque_per_volt", "N mm/V", (1.528e-3, 1.672e-3)[i]),
        ):
            yield within(f"simple {axis} {name}", front[key][i], unit, reference, 1e-3, "D, design", condition)


def _contact() -> Iterator[Row]:
    for surface, reference in (("ptfe", 0.29), ("card", 0.51), ("sandpaper", 1.02)):
        mu = number(f"contact.friction_{surface}")
        yield near(f"friction {surface}", mu.value, "1", reference, 0.0, "P, IJRR19", "parameter")
    pull, cone = _worst_ground_force()
    yield near("largest pull of the ground", pull, "N", 0.0, 0.0, "unilateral contact", "10 000 random foot states")
    yield near(
        "friction cone, excess", cone, "1", 0.0, 1e-12, "Coulomb law, IJRR19", "largest |Ft| / (mu N) - 1, 10 000 random foot states"
    )


def _worst_ground_force() -> tuple[float, float]:
    rng, n = np.random.default_rng(0), 10_000
    law = {name: value(f"contact.{name}") for name in ("stiffness", "damping", "slip_speed")}
    mu, normal = value("contact.friction"), (0.0, 0.0, 1.0)
    before, after = (tuple(rng.normal(0.0, 0.3, (3, n))) for _ in (0, 1))
    touch = contact.approach(rng.normal(0.0, 0.01, n), before, normal, mu, SERVO_MS, **law)
    x, y, z = contact.clamp(touch, after, mu)
    loaded = z > 0
    return max(0.0, float(-z.min())), max(0.0, float((np.hypot(x, y)[loaded] / (mu * z[loaded])).max() - 1.0))


def _settled() -> Iterator[Row]:
    source = "this model"
    reason = "rail off, no friction; 0.43 is linear, but the lever grows as the foot rises"
    yield within("static sag, settled", static_sag(rail=False, friction=0.0), "mm", 0.43, 0.05, CALC, reason, known=True)
    mu = value("contact.friction")
    yield Row("static sag, standing", static_sag(rail=True, friction=mu), "mm", None, 0.0, True, source, f"rail on, friction {mu}")
