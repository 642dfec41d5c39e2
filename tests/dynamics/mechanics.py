"""Energy and momentum of a whole robot, summed body by body from plain velocities: nothing here knows the step's matrices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hamr_description.names import LEGS, MIRROR
from hamr_dynamics.batch import SIGN, BatchSim
from hamr_dynamics.plant import flatten, unflatten
from hamr_sim_full import transmission
from hamr_sim_full.parameters import FLEXURES


@dataclass(frozen=True)
class Motion:
    """Of one robot: kinetic and potential energy (N mm), mass (g), centre of mass (mm), linear (g mm/ms) and angular momentum about the
    centre of mass (g mm^2/ms), all in world axes."""

    kinetic: float
    potential: float
    mass: float
    com: np.ndarray
    linear: np.ndarray
    angular: np.ndarray


def motion(sim: BatchSim, robot: int = 0, *, gravity: float = 0.0) -> Motion:
    """What a robot of `sim` carries now; springs only (drives neutral, stops at rest)."""
    turn = rotation(sim.quaternion[robot])
    omega, velocity = sim.angular_velocity[robot], turn.T @ sim.velocity[robot]
    chassis = sim.plant.chassis
    bodies = [(chassis["mass"], tensor(chassis["inertia"]), np.array(chassis["com"], float), np.zeros(3), np.zeros(3))]
    potential = 0.0
    for i, leg in enumerate(LEGS):
        parameters = lane_parameters(sim, robot, i)
        q, v = (x[robot, 2 * i : 2 * i + 2] * SIGN[2 * i : 2 * i + 2] for x in (sim.q, sim.qd))
        state = sim.plant.leg(tuple(q), tuple(v), (0.0, 0.0), parameters)
        sx, sy = MIRROR[leg]
        for body in state.bodies:
            point = np.array([c.value for c in body.com], float)
            rate = np.array([c.rate(v) for c in body.com], float)
            spin = sum(np.array(axis, float) * angle.rate(v) for axis, angle in body.turns) if body.turns else np.zeros(3)
            flip = np.array([sx, sy, 1.0])
            inertia = tensor(body.inertia) * np.outer(flip, flip)
            bodies.append((body.mass, inertia, flip * point, flip * rate, np.array([sy, sx, sx * sy]) * spin))
        potential += springs(sim.plant.name, q, parameters)
    if sim.environment == "suspended":
        bodies = bodies[1:]
    mass = sum(m for m, *_ in bodies)
    kinetic, linear, moment, angular = 0.0, np.zeros(3), np.zeros(3), np.zeros(3)
    for m, inertia, point, rate, spin in bodies:
        w, u = omega + spin, velocity + np.cross(omega, point) + rate
        kinetic += 0.5 * m * u @ u + 0.5 * w @ inertia @ w
        linear, moment = linear + m * u, moment + m * point
        angular = angular + np.cross(point, m * u) + inertia @ w
    com = moment / mass
    height = sim.position[robot] + turn @ com
    return Motion(kinetic, potential + mass * gravity * height[2], mass, height, turn @ linear, turn @ (angular - np.cross(com, linear)))


def springs(name: str, q, p) -> float:
    """Energy of a leg's springs, N mm."""
    if name == "full":
        t = transmission.solve(tuple(q), p)
        angles = transmission.flexure_angles(t)
        flexures = sum(0.5 * p[f"k_{f}"] * angles[f].value ** 2 for f in FLEXURES)
        return flexures + sum(0.5 * (p["tip_stiffness"] + p["drive_spring"]) * tip.value**2 for tip in t.tips)
    return sum(0.5 * k * x * x for k, x in zip(p["stiffness"], q, strict=True))


def lane_parameters(sim: BatchSim, robot: int, leg: int) -> dict:
    """The parameters that leg number `leg` of a robot runs with."""
    like = sim.plant.parameters(LEGS[leg])
    flat = flatten(like)
    return unflatten({name: sim.parameter(name)[robot, leg] if name in sim.parameter_names else x for name, x in flat.items()}, like)


def tensor(six) -> np.ndarray:
    """(3, 3) of [xx, yy, zz, xy, xz, yz]."""
    xx, yy, zz, xy, xz, yz = (float(x) for x in six)
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def rotation(wxyz) -> np.ndarray:
    """Matrix chassis -> world."""
    w, x, y, z = wxyz
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + 2 * w * cross + 2 * cross @ cross


def undamped(sim: BatchSim) -> BatchSim:
    """The same simulator with every damper at zero."""
    for name in sim.parameter_names:
        if name.startswith(("b_", "damping")) or name == "tip_damping":
            sim.set_parameter(name, 0.0)
    return sim
