"""The published lumped fit (REPO's HAMRSimple) as a plant, for fair comparison with the paper.

Its own joints are swing about y, then lift about x. It runs in the project's hip angles all the same: the two sets of
angles are tied by the direction of the foot from the hip, so state, targets and contact mean the same on every backend.
"""

from __future__ import annotations

import math

from hamr_description.numbers import value
from hamr_dynamics import jet, vec
from hamr_dynamics.jet import Jet
from hamr_dynamics.leg import Body, Leg

from .simple import rigid, simple_parameters


def published_parameters(leg: str) -> dict:
    """Parameters of one leg (g, mm, ms, N, V, rad), front-left frame; stops are HAMR-simple's."""
    group = f"simple_published.{'front' if leg[0] == 'f' else 'rear'}"
    p = {key: tuple(float(x) for x in value(f"simple_published.{key}")) for key in ("hip", "stiffness", "damping")}
    p |= {"mass": value(f"{group}.mass")} | {key: tuple(float(x) for x in value(f"{group}.{key}")) for key in ("com", "inertia")}
    p |= {key: value(f"simple_published.{key}") for key in ("leg_length", "rest_lift", "torque_per_volt")}
    p["direction"] = (0.0, math.sin(p["rest_lift"]), -math.cos(p["rest_lift"]))  # hip to foot at rest: zero of the hip angles
    simple = simple_parameters(leg)
    return p | {key: simple[key] for key in ("stop_low", "stop_high", "stop_stiffness", "stop_damping", "tip_per_angle")}


def published_leg(q, v, drive, p) -> Leg:
    """The published leg; arguments as `hamr_sim_full.leg.full_leg`."""
    swing, lift = jet.variables(q)
    (sb, cb), (sp, cp) = jet.sincos(swing), jet.sincos(lift)
    x, y, z = p["direction"]
    a, b = cb * x - sb * y, sb * x + cb * y
    d = (a, cp * b - sp * z, sp * b + cp * z)  # unit vector hip -> foot
    s_lift, c_lift = d[1], jet.sqrt(1.0 - d[1] * d[1])
    inverse = jet.reciprocal(c_lift)
    s_swing, c_swing = -d[0] * inverse, -d[2] * inverse
    yaw, roll = jet.angle(s_swing, c_swing), jet.angle(s_lift, c_lift)

    def point(r):
        u, w = c_lift * r[1] - s_lift * r[2], s_lift * r[1] + c_lift * r[2]
        return vec.add((c_swing * r[0] + s_swing * w, u, c_swing * w - s_swing * r[0]), p["hip"])

    ss, cs, sl, cl = (j.value for j in (s_swing, c_swing, s_lift, c_lift))
    rotation = ((cs, ss * sl, ss * cl), (0.0, cl, -sl), (-ss, cs * sl, cs * cl))
    body = Body(
        p["mass"], vec.rotate_tensor(rotation, p["inertia"]), point(p["com"]), (((0.0, 1.0, 0.0), yaw), ((cs, 0.0, -ss), roll))
    )
    angles: tuple[Jet, Jet] = (yaw, roll - p["rest_lift"])
    torque = [0.0, 0.0]
    for angle, volt in zip(angles, drive, strict=True):
        torque = [torque[k] + p["torque_per_volt"] * volt * angle.d[k] for k in (0, 1)]
    return rigid(body, point((0.0, 0.0, -p["leg_length"])), angles, q, v, torque, p)
