"""HAMR-simple's constants from HAMR-full's linear limit: `python -m hamr_sim_residual.derive` writes hamr_description/simple.yaml.

HAMR-simple is a rigid leg on a universal joint (lift about x, then swing about z) that equals HAMR-full to first order:
mass matrix, stiffness, damping and torque per volt at q = 0, total mass, centre of mass and inertia of the robot. The
entries of the leg's inertia tensor that the mass matrix at q = 0 leaves open are fitted to HAMR-full's mass matrix over the
static reach of the drive; its centre of mass is the one nearest to HAMR-full's linear momentum that a rigid body can have.
"""

from __future__ import annotations

from importlib import resources
from pathlib import Path

import numpy as np
import yaml
from scipy.optimize import brentq

from hamr_description.names import LEGS, MIRROR
from hamr_description.numbers import value
from hamr_dynamics import vec
from hamr_dynamics.leg import Inertia, inertia
from hamr_sim_full import transmission
from hamr_sim_full.leg import full_leg
from hamr_sim_full.parameters import leg_parameters

REACH = np.radians(20.0)  # static reach of the drive, both axes (hamr_facts section 3)
ZERO2, ZERO3 = (0.0, 0.0), (0.0, 0.0, 0.0)


def _inertia(q, p) -> Inertia:
    return inertia(full_leg(q, ZERO2, ZERO2, p).bodies, ZERO2, ZERO3, ZERO3)


def fit_tensor(p: dict) -> tuple[float, ...]:
    """(6,) inertia about the hip: xx, zz, xz from the mass matrix at q = 0, yy, xy, yz by least squares over the reach."""
    izz, ixz, ixx = _inertia(ZERO2, p).leg
    rows, targets = [], []
    for swing in np.linspace(-REACH, REACH, 9):
        for lift in np.linspace(-REACH, REACH, 9):
            _, m_sl, m_ll = _inertia((swing, lift), p).leg
            s, c = np.sin(swing), np.cos(swing)
            rows += [[s * s, -2 * s * c, 0.0], [0.0, 0.0, -s]]
            targets += [m_ll - c * c * ixx, m_sl - c * ixz]
    iyy, ixy, iyz = np.linalg.lstsq(np.array(rows), np.array(targets), rcond=None)[0]
    return ixx, iyy, izz, ixy, ixz, iyz


def rigid_moment(tensor, moment: np.ndarray, mass: float) -> np.ndarray:
    """The first mass moment (3,) nearest to `moment` that a rigid body with this mass and tensor about the origin can have.

    A mass distribution exists if its second moments S = tr(I)/2 - I exceed those of its centre: moment . S^-1 moment <= mass
    (Wensing, Kim, Slotine 2018). A tenth is kept for extent about the centre.
    """
    xx, yy, zz, xy, xz, yz = tensor
    matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    size, axes = np.linalg.eigh(0.5 * np.trace(matrix) * np.eye(3) - matrix)
    along = axes.T @ moment

    def shrunk(weight: float) -> np.ndarray:
        return along / (1.0 + weight / size)

    def excess(weight: float) -> float:
        return float(np.sum(shrunk(weight) ** 2 / size) - 0.9 * mass)

    return moment if excess(0.0) <= 0 else axes @ shrunk(brentq(excess, 0.0, 1e3))


def leg_constants(leg: str) -> dict:
    """Constants of one leg in the front-left frame (units of numbers.yaml; shape as in hamr_description/simple.yaml)."""
    p = leg_parameters(leg)
    state = full_leg(ZERO2, ZERO2, ZERO2, p)
    whole = _inertia(ZERO2, p)
    swing, lift = (column[3:] for column in whole.coupling)
    moment = np.array([swing[1], (lift[2] - swing[0]) / 2, -lift[1]])  # mass times centre, from momentum per rate
    tensor = fit_tensor(p)
    com = rigid_moment(tensor, moment, whole.mass) / whole.mass
    about_com = np.array(tensor) - np.array(vec.point_inertia(whole.mass, com))
    ratio = np.array([state.tips[i].d[i] for i in (0, 1)])

    def stop(side: float) -> list[float]:
        def tip(i: int, x: float) -> float:
            q = (x, 0.0) if i == 0 else (0.0, x)
            return transmission.solve(q, p).tips[i].value - side * p["stop"]

        return [float(brentq(lambda x, i=i: tip(i, x), -1.2, 1.2)) for i in (0, 1)]

    return {
        "mass": whole.mass, "com": com, "inertia": about_com,
        "stiffness": [state.stiffness[0], state.stiffness[2]], "damping": [state.damping[0], state.damping[2]],
        "torque_per_volt": p["drive_force"] * ratio, "tip_per_angle": ratio,
        "stop_low": stop(-1.0), "stop_high": stop(1.0),
        "stop_stiffness": p["stop_stiffness"] * ratio**2, "stop_damping": p["stop_damping"] * ratio**2,
    }  # fmt: skip


def _mirrored(points, tensor, leg: str):
    """A leg-frame point and tensor in chassis axes."""
    sx, sy = MIRROR[leg]
    return np.array(points) * (sx, sy, 1), np.array(tensor) * (1, 1, 1, sx * sy, sx, sy)


def chassis_constants(front: dict, rear: dict) -> dict:
    """Chassis that, with the simple legs, gives HAMR-full's mass, centre of mass and inertia at q = 0."""
    mass = value("chassis.mass")
    moment = mass * value("chassis.com")
    tensor = value("chassis.inertia") + np.array(vec.point_inertia(mass, value("chassis.com")))
    for leg in LEGS:
        full, simple = _inertia(ZERO2, leg_parameters(leg)), front if leg[0] == "f" else rear
        point = value("leg.hip") + simple["com"]
        about_origin = simple["inertia"] + np.array(vec.point_inertia(simple["mass"], point))
        point_full, tensor_full = _mirrored(full.moment, full.tensor, leg)
        point_simple, tensor_simple = _mirrored(simple["mass"] * point, about_origin, leg)
        moment = moment + point_full - point_simple
        tensor = tensor + tensor_full - tensor_simple
    com = moment / mass
    return {"mass": mass, "com": com, "inertia": tensor - np.array(vec.point_inertia(mass, com))}


def derive() -> dict:
    """All constants of HAMR-simple."""
    front, rear = leg_constants("fl"), leg_constants("rl")
    groups = {"chassis": chassis_constants(front, rear), "front": front, "rear": rear}
    return {g: {k: [float(x) for x in np.ravel(v)] if np.ndim(v) else float(v) for k, v in c.items()} for g, c in groups.items()}


def main() -> None:
    """Writes the file that ships."""
    head = "# Generated by `python -m hamr_sim_residual.derive`; do not edit. HAMR-simple from HAMR-full's linear limit (g, mm, ms, N, V, rad),\n"
    head += "# legs in the mirrored front-left frame; centre of mass relative to the hip, inertia [xx, yy, zz, xy, xz, yz] about it.\n"
    path = Path(str(resources.files("hamr_description"))) / "simple.yaml"
    path.write_text(head + yaml.safe_dump(derive(), sort_keys=False, default_flow_style=None, width=160))


if __name__ == "__main__":
    main()
