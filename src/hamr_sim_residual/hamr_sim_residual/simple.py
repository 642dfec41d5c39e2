"""HAMR-simple as a plant: a rigid leg on a universal joint, with springs, dampers, end stops and a torque per volt."""

from __future__ import annotations

from hamr_description.mirror import end
from hamr_description.numbers import value
from hamr_description.posture import neutral_foot
from hamr_description.simple_constants import simple_constants
from hamr_dynamics import jet, vec
from hamr_dynamics.jet import Jet
from hamr_dynamics.leg import Body, Leg, project
from hamr_dynamics.stops import stop_force

X = (1.0, 0.0, 0.0)


def simple_parameters(leg: str) -> dict:
    """HAMR-simple's parameters of one leg (g, mm, ms, N, V, rad), front-left frame."""
    group = simple_constants()[end(leg)]
    p = {k: tuple(v) if isinstance(v, list) else v for k, v in group.items()}
    p["hip"] = tuple(float(x) for x in value("leg.hip"))
    p["foot"] = foot_from_hip()
    return p


def foot_from_hip() -> tuple[float, float, float]:
    """Foot relative to the hip at q = 0 in the front-left frame, mm."""
    return tuple(float(x) for x in neutral_foot("fl") - value("leg.hip"))


def simple_leg(q, v, drive, p) -> Leg:
    """HAMR-simple's leg; arguments as `hamr_sim_full.leg.full_leg`, p from `simple_parameters`."""
    return rigid_leg(q, v, tuple(k * u for k, u in zip(p["torque_per_volt"], drive, strict=True)), p)


def rigid_leg(q, v, torque, p) -> Leg:
    """The rigid leg under given hip torques (swing, lift), N mm: HAMR-simple's f_s(q, v, torque) of the paper."""
    swing, lift = jet.variables(q)
    (sb, cb), (sp, cp) = jet.sincos(swing), jet.sincos(lift)

    def point(r):
        x, y, z = r
        a, b = cb * x - sb * y, sb * x + cb * y
        return a + p["hip"][0], cp * b - sp * z + p["hip"][1], sp * b + cp * z + p["hip"][2]

    s, c = (sb.value, cb.value), (sp.value, cp.value)
    rotation = ((s[1], -s[0], 0.0), (c[1] * s[0], c[1] * s[1], -c[0]), (c[0] * s[0], c[0] * s[1], c[1]))
    body = Body(
        p["mass"], vec.rotate_tensor(rotation, p["inertia"]), point(p["com"]), ((X, lift), ((0.0, -c[0], c[1]), swing))
    )
    return rigid(body, point(p["foot"]), (swing, lift), q, v, torque, p)


def rigid(body: Body, foot, angles: tuple[Jet, Jet], q, v, torque, p) -> Leg:
    """A one-body leg with a spring and damper on each of two joint angles (jets) and stops on the hip angles."""
    force, columns, springs, dampers, stops = list(torque), [], [], [], []
    for i, angle in enumerate(angles):
        pull = p["stiffness"][i] * angle.value + p["damping"][i] * angle.rate(v)
        force = [force[k] - pull * angle.d[k] for k in (0, 1)]
        columns.append(angle.d)
        springs.append(p["stiffness"][i])
        dampers.append(p["damping"][i])
    for i in (0, 1):
        bounds, law = (p["stop_low"][i], p["stop_high"][i]), (p["stop_stiffness"][i], p["stop_damping"][i])
        stop = stop_force(q[i], v[i], *bounds, *law, p.get("step"))
        force[i] = force[i] + stop.force
        columns.append((1.0 - i, float(i)))
        springs.append(stop.stiffness)
        dampers.append(stop.damping)
        stops.append(stop.active)
    tips = tuple(ratio * a for ratio, a in zip(p["tip_per_angle"], jet.variables(q), strict=True))
    return Leg(
        bodies=[body],
        foot=foot,
        force=tuple(force),
        stiffness=project(columns, springs),
        damping=project(columns, dampers),
        tips=tips,
        tip_force=tuple(t / r for t, r in zip(torque, p["tip_per_angle"], strict=True)),
        torque=tuple(torque),
        stop=tuple(stops),
    )
