"""HAMR-full as a plant: one leg with its transmission, flexures, piezo actuators and end stops."""

from __future__ import annotations

from hamr_dynamics import vec
from hamr_dynamics.jet import Jet
from hamr_dynamics.leg import Body, Leg, project
from hamr_dynamics.stops import stop_force

from . import transmission as kinematics
from .parameters import FLEXURES


def full_leg(q, v, drive, p) -> Leg:
    """HAMR-full's leg.

    Args:
        q: (2,) swing and lift angle, rad. v: (2,) their rates, rad/ms.
        drive: (2,) voltages minus neutral, of the swing and lift actuator, V, leg frame.
        p: `leg_parameters`.
    """
    t = kinematics.solve(q, p)
    angles = kinematics.flexure_angles(t)
    columns = [angles[f].d for f in FLEXURES]
    springs = [p[f"k_{f}"] for f in FLEXURES]
    dampers = [p[f"b_{f}"] for f in FLEXURES]
    force = [0.0, 0.0]
    for f, k, b in zip(FLEXURES, springs, dampers, strict=True):
        pull = k * angles[f].value + b * angles[f].rate(v)
        force = [force[i] - pull * angles[f].d[i] for i in (0, 1)]

    tips, tip_force, torque, stops = t.tips, [], [0.0, 0.0], []
    for tip, volt in zip(tips, drive, strict=True):
        push = p["drive_force"] * volt - p["drive_spring"] * tip.value
        tip_force.append(push)
        torque = [torque[i] + push * tip.d[i] for i in (0, 1)]
        stop = stop_force(tip.value, tip.rate(v), -p["stop"], p["stop"], p["stop_stiffness"], p["stop_damping"], p.get("step"))
        stops.append(stop.active)
        net = push - p["tip_stiffness"] * tip.value - p["tip_damping"] * tip.rate(v) + stop.force
        force = [force[i] + net * tip.d[i] for i in (0, 1)]
        columns.append(tip.d)
        springs.append(p["tip_stiffness"] + p["drive_spring"] + stop.stiffness)
        dampers.append(p["tip_damping"] + stop.damping)

    return Leg(
        bodies=_bodies(t, p),
        foot=kinematics.foot(t, p),
        force=tuple(force),
        stiffness=project(columns, springs),
        damping=project(columns, dampers),
        tips=tips,
        tip_force=tuple(tip_force),
        torque=tuple(torque),
        stop=tuple(stops),
    )


X, Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


def _bodies(t: kinematics.Transmission, p) -> list[Body]:
    """The eight moving links. The swing chain turns about z (S4 also about x of S3), the lift chain about x (L4 also about z of L3)."""
    rotation = kinematics.rotations(t)
    x_of_s3 = (t.psi.cos.value, t.psi.sin.value, 0.0)
    z_of_l3 = (0.0, -t.lift.sin.value, t.lift.cos.value)

    def slider(name, origin, tip):
        x, y, z = vec.add(p[origin], p[f"com_{name}"])
        return Body(p[f"mass_{name}"], p[f"inertia_{name}"], (Jet(x), tip + y, Jet(z)))

    def link(name, com, *turns):
        return Body(p[f"mass_{name}"], vec.rotate_tensor(rotation[name], p[f"inertia_{name}"]), com, turns)

    return [
        slider("S1", "swing_slider", t.tips[0]),
        link("S2", kinematics.on_s2(t, p, p["com_S2"]), (Z, t.sigma.angle)),
        link("S3", kinematics.on_s3(t, p["com_S3"]), (Z, t.psi.angle)),
        link("S4", kinematics.on_s4(t, p, p["com_S4"]), (Z, t.psi.angle), (x_of_s3, t.alpha.angle)),
        slider("L1", "lift_slider", t.tips[1]),
        link("L2", kinematics.on_l2(t, p, p["com_L2"]), (X, t.lam.angle)),
        link("L3", kinematics.on_l3(t, p["com_L3"]), (X, t.lift.angle)),
        link("L4", kinematics.on_l4(t, p, p["com_L4"]), (X, t.lift.angle), (z_of_l3, t.swing.angle)),
    ]
