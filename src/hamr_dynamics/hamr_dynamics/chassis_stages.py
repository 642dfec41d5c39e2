"""The traced stages of the chassis of a robot that walks: ahead by half a step, and its equations with those of the legs in them."""

from __future__ import annotations

from hamr_description.names import LEGS, MIRROR

from . import bank_stages, vec
from .emit import Stage
from .layout import BASE, BODY, GROUNDED, INCREMENT, NEAR, POSE, REACH, by_leg
from .step import ROW6, BaseState, base_ahead, chassis_terms, finish_base, solve6


def predict(h: float, *, effects: bool = False) -> Stage:
    """Base half a step ahead."""
    inputs, pose, near = {"base": BASE}, POSE, NEAR
    if effects:
        inputs |= {"body": (*BODY, *bank_stages.BODY)}
        pose, near = (*POSE, *bank_stages.POSE), (*NEAR, *bank_stages.NEAR)
    stage = Stage("predict", inputs, {"pose": pose, "near": by_leg(near)})
    state = _base_state(stage)
    quaternion, matrix, height, velocity, omega_mid = base_ahead(state, h)
    stage.write("pose", "quaternion", quaternion)
    stage.write("pose", "rows", tuple(x for row in matrix for x in row))
    stage.write("pose", "omega_mid", omega_mid)
    for leg in LEGS:  # the same in each leg's mirrored frame
        for name, vector in (("omega", state.omega), ("omega_mid", omega_mid)):
            stage.write("near", f"{leg}.{name}", mirror_spin(leg, vector))
        for name, vector in (("velocity", velocity), ("normal", matrix[2])):
            stage.write("near", f"{leg}.{name}", mirror(leg, vector))
        stage.write("near", f"{leg}.height", height)
    if effects:
        pull = bank_stages.surroundings(stage, state, matrix)
        for leg in LEGS:
            stage.write("near", f"{leg}.pull", mirror(leg, pull))
    return stage


def balance_soft(h: float, *, effects: bool = False) -> Stage:
    """First base solve, contact on the left-hand side."""
    pose = (*POSE, *bank_stages.POSE) if effects else POSE
    inputs = {"pose": pose, "body": BODY, "reach": by_leg(REACH)}
    stage = Stage("balance_soft", inputs, {"soft": by_leg(INCREMENT)})
    _write_increment(stage, "soft", _balance(stage, "soft", h))
    return stage


def balance_free(h: float, *, effects: bool = False) -> Stage:
    """Second base solve with the ground's forces: the new base, and its increment for each leg."""
    pose = (*POSE, *bank_stages.POSE) if effects else POSE
    inputs = {"base": BASE, "pose": pose, "body": BODY, "reach": by_leg(REACH), "grounded": by_leg(GROUNDED)}
    stage = Stage("balance_free", inputs, {"new_base": BASE, "free": by_leg(INCREMENT)})
    increment = _balance(stage, "free", h)
    flat = stage.reads("pose", "rows", 9)
    new = finish_base(_base_state(stage), stage.reads("pose", "quaternion", 4), (flat[:3], flat[3:6], flat[6:]), increment, h)
    for name in ("position", "quaternion", "velocity", "omega", "alpha"):
        stage.write("new_base", name, getattr(new, name))
    _write_increment(stage, "free", increment)
    return stage


def mirror(leg: str, v) -> tuple:
    """A vector between chassis axes and the leg frame."""
    sx, sy = MIRROR[leg]
    return v[0] * float(sx), v[1] * float(sy), v[2]


def mirror_spin(leg: str, v) -> tuple:
    """A pseudovector between chassis axes and the leg frame."""
    sx, sy = MIRROR[leg]
    return v[0] * float(sy), v[1] * float(sx), v[2] * float(sx * sy)


def _base_state(stage: Stage) -> BaseState:
    sizes = {"position": 3, "quaternion": 4, "velocity": 3, "omega": 3, "alpha": 3}
    return BaseState(*(stage.reads("base", name, n) for name, n in sizes.items()))


def _balance(stage: Stage, kind: str, h: float) -> tuple:
    """Base equations, solved."""
    omega_mid, matrix = stage.reads("pose", "omega_mid", 3), stage.reads("pose", "rows", 9)
    lift = vec.scale(matrix[6:9], stage.read("body", "gravity"))
    if "pull.0" in stage.inputs["pose"]:
        lift = vec.add(lift, stage.reads("pose", "pull", 3))
    body = stage.read("body", "mass"), stage.reads("body", "com", 3), stage.reads("body", "inertia", 6)
    chassis, rhs = chassis_terms(*body, omega_mid, lift, h)
    total = vec.add(chassis, _sum_legs(stage, "reach", f"{kind}_matrix", 21))
    rhs = vec.add(rhs, _sum_legs(stage, "reach", f"{kind}_rhs", 6))
    if "tow.0" in stage.inputs["pose"]:
        rhs = vec.add(rhs, vec.scale((0.0, 0.0, 0.0, *stage.reads("pose", "tow", 3)), h))
    if kind == "free":
        rhs = vec.add(rhs, _sum_legs(stage, "grounded", "rhs", 6))
    return solve6(total, rhs)


def _sum_legs(stage: Stage, array: str, name: str, n: int) -> tuple:
    """Sum over the legs of (n,) rows given in leg frames: a 6-vector or the lower triangle of a 6 x 6."""
    total = (0.0,) * n
    for leg in LEGS:
        signs = [*mirror_spin(leg, (1.0, 1.0, 1.0)), *mirror(leg, (1.0, 1.0, 1.0))]
        weights = signs if n == 6 else [signs[i] * signs[j] for i, j in ROW6]
        values = stage.reads(array, f"{leg}.{name}", n)
        total = vec.add(total, tuple(w * x for w, x in zip(weights, values, strict=True)))
    return total


def _write_increment(stage: Stage, array: str, increment) -> None:
    for leg in LEGS:
        stage.write(array, f"{leg}.increment", mirror_spin(leg, increment[:3]) + mirror(leg, increment[3:]))
