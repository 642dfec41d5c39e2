"""The traced stages of a plant: `step` fed with named rows. Row names are the layout of every array that the kernels touch.

Arrays (rows x lanes; leg lanes are leg-major: lane = leg * robots + robot, in the order of names.LEGS):
    state  leg lanes    q v a, stop counts
    drive  leg lanes    voltage minus neutral in the leg frame, or hip torque from a network
    param  leg lanes    what differs between lanes
    base   robot lanes  chassis state;   body  robot lanes  chassis parameters
A plant with effects has more rows behind some of these (`bank_stages`).
"""

from __future__ import annotations

from collections.abc import Callable

from hamr_description.names import LEGS, MIRROR

from . import bank_stages, scalar, vec
from .contact import Contact
from .emit import Part, Stage, rows
from .plant import Plant, flatten, unflatten
from .step import (
    ROW6,
    BaseState,
    LegState,
    Reach,
    ahead,
    apply_ground,
    base_ahead,
    chassis_terms,
    finish,
    finish_base,
    ground_force,
    leg_increment,
    reach_leg,
    solve6,
    step_suspended,
)

STATE = rows(q=2, v=2, a=2, stops=2)
DRIVE = rows(drive=2)
TARGET = rows(target=2, kp=2, kd=2)
BASE = rows(position=3, quaternion=4, velocity=3, omega=3, alpha=3)
BODY = rows(mass=1, com=3, inertia=6, gravity=1)
GROUND = ("friction", "contact_stiffness", "contact_damping", "slip_speed")
ENVIRONMENT = (*GROUND, "gravity")
POSE = rows(quaternion=4, rows=9, omega_mid=3)
NEAR = rows(omega=3, omega_mid=3, velocity=3, normal=3, height=1)
INCREMENT = rows(increment=6)
SEEN = rows(tip=2, tip_rate=2, tip_force=2, torque=2)
REACH = rows(
    soft_matrix=21, soft_rhs=6, free_matrix=21, free_rhs=6, soft_gain=12, free_gain=12, soft_own=2, free_own=2, solve=3,
    jacobian=6, point=3, contact=6, stop=2,
)  # fmt: skip
GROUNDED = rows(rhs=6, own=2, force=3)


def state_rows(plant: Plant) -> tuple[str, ...]:
    """Rows of the legs' state."""
    return (*STATE, *bank_stages.STATE) if plant.effects else STATE


def body_rows(plant: Plant) -> tuple[str, ...]:
    """Rows of the chassis's parameters."""
    return (*BODY, *bank_stages.BODY) if plant.effects else BODY


def seen_rows(plant: Plant) -> tuple[str, ...]:
    """Rows of what `observe` sees."""
    return (*SEEN, *bank_stages.MEASURED) if plant.effects else SEEN


def renewed(plant: Plant) -> dict[str, tuple[str, int]]:
    """Outputs that take the place of an input: output -> (input, first row)."""
    own = {"new_state": ("state", 0), "new_base": ("base", 0)}
    more = bank_stages.RENEWED if plant.effects else {}
    return own | {new: (old, first + len(STATE) * (old == "state")) for new, (old, first) in more.items()}


def by_leg(names: tuple[str, ...]) -> tuple[str, ...]:
    """Rows of a leg-lane array as a robot lane sees them: row-major, legs inside (name.i of fl rl fr rr)."""
    return tuple(f"{leg}.{name}" for name in names for leg in LEGS)


def parameter_rows(plant: Plant) -> tuple[str, ...]:
    """Leg parameters that vary by lane: tunable ones, and whatever differs between the legs."""
    legs = [flatten(plant.parameters(leg)) for leg in LEGS]
    different = [k for k in legs[0] if k.split(".")[0] in plant.tunable or len({leg[k] for leg in legs}) > 1]
    return (*different, *ENVIRONMENT, *(bank_stages.PARAMETERS if plant.effects else ()))


def _parameters(stage: Stage, plant: Plant) -> dict:
    like = plant.parameters(LEGS[0])
    flat = {k: stage.read("param", k) if k in stage.inputs["param"] else x for k, x in flatten(like).items()}
    return unflatten(flat, like)


def _state(stage: Stage) -> LegState:
    return LegState(*(stage.reads("state", name, 2) for name in "qva"))


def _write_state(stage: Stage, state: LegState, stops) -> None:
    for name in "qva":
        stage.write("new_state", name, getattr(state, name))
    stage.write("new_state", "stops", tuple(n + s for n, s in zip(stage.reads("state", "stops", 2), stops, strict=True)))


def _arrays(plant: Plant) -> dict[str, tuple[str, ...]]:
    return {"state": state_rows(plant), "param": parameter_rows(plant)}


def _driven(plant: Plant) -> dict[str, tuple[str, ...]]:
    return {"state": state_rows(plant), "drive": DRIVE, "param": parameter_rows(plant)}


def sense(plant: Plant, h: float) -> list[Part]:
    """What the sensors say, which the leg law sees; nothing of a plant without effects, whose sensors are true."""
    return bank_stages.sense(_arrays(plant), h) if plant.effects else []


def command(plant: Plant, h: float) -> list[Part]:
    """The drive that acts, of the commanded one; nothing of a plant without effects."""
    return bank_stages.command(_arrays(plant), DRIVE, h) if plant.effects else []


def chain(plant: Plant, environment: str, h: float) -> list[tuple[Part, int]]:
    """The step under a drive, in order: parts, and the lanes that each has of a robot."""
    found = [(part, 4) for part in _forces(plant, h)]
    if environment == "suspended":
        return [*found, (Part(suspended(plant, h)), 4)]
    first, effects = predict(h, effects=plant.effects), plant.effects
    rest = [(reach(plant, h), 4), (balance_soft(h, effects=effects), 1), (grounded(plant, h), 4), (balance_free(h, effects=effects), 1),
            (finish_legs(h), 4)]  # fmt: skip
    return [(Part(first), 1), *found, *((Part(stage), lanes) for stage, lanes in rest)]


def _forces(plant: Plant, h: float) -> list[Part]:
    def middle(stage: Stage) -> tuple[tuple, tuple]:
        state = _state(stage)
        return ahead(state, h)[0], state.v

    return bank_stages.forces(plant, _arrays(plant), DRIVE, middle, lambda stage: _parameters(stage, plant), h) if plant.effects else []


def _leg_arrays(plant: Plant) -> tuple[dict[str, tuple[str, ...]], dict[str, tuple[str, ...]]]:
    """Inputs of a stage that evaluates `_leg`, and its outputs besides its own."""
    more, moved = ({"equations": bank_stages.EQUATIONS}, {"moved": bank_stages.MOVED}) if plant.effects else ({}, {})
    return _driven(plant) | more, moved


def _leg(plant: Plant, stage: Stage, h: float) -> Callable:
    """The plant's leg function, with the equations that effects have changed if its kernels carry them."""
    return bank_stages.leg(plant, stage, h) if plant.effects else plant.leg


def suspended(plant: Plant, h: float) -> Stage:
    """A whole step of a leg on a fixed chassis."""
    inputs, moved = _leg_arrays(plant)
    stage = Stage("suspended", inputs, {"new_state": STATE} | moved)
    state, leg = step_suspended(
        _leg(plant, stage, h), _state(stage), stage.reads("drive", "drive", 2), _parameters(stage, plant), stage.read("param", "gravity"), h
    )
    _write_state(stage, state, leg.stop)
    return stage


def suspended_leg(plant: Plant, h: float) -> Stage:
    """The same step without the stop counts: smooth rows only, for derivatives."""
    stage = Stage("suspended", {"state": STATE[:6], "drive": DRIVE, "param": parameter_rows(plant)}, {"new_state": STATE[:6]})
    state, _ = step_suspended(
        plant.leg, _state(stage), stage.reads("drive", "drive", 2), _parameters(stage, plant), stage.read("param", "gravity"), h
    )
    for name in "qva":
        stage.write("new_state", name, getattr(state, name))
    return stage


def servo(limit: float) -> Stage:
    """The leg law in the leg frame: drive = clip(kp (target - q) - kd v)."""
    stage = Stage("servo", {"state": STATE, "target": TARGET}, {"drive": DRIVE})
    q, v = stage.reads("state", "q", 2), stage.reads("state", "v", 2)
    target, kp, kd = (stage.reads("target", name, 2) for name in ("target", "kp", "kd"))
    law = (scalar.clip(kp[i] * (target[i] - q[i]) - kd[i] * v[i], -limit, limit) for i in (0, 1))
    stage.write("drive", "drive", tuple(law))
    return stage


def observe(plant: Plant, h: float) -> Stage:
    """What only a simulator knows of a leg: actuator tips, their rates and forces, and the drive's hip torque."""
    stage = Stage("observe", _driven(plant), {"seen": seen_rows(plant)})
    state = _state(stage)
    leg = plant.leg(state.q, state.v, stage.reads("drive", "drive", 2), _parameters(stage, plant))
    if plant.effects:
        leg = bank_stages.seen(stage, leg, h)
    tips = tuple(t.value for t in leg.tips), tuple(t.rate(state.v) for t in leg.tips)
    tip, tip_rate = bank_stages.tips(stage, leg, state.v) if plant.effects else tips
    stage.write("seen", "tip", tip)
    stage.write("seen", "tip_rate", tip_rate)
    stage.write("seen", "tip_force", tuple(leg.tip_force))
    stage.write("seen", "torque", tuple(leg.torque))
    return stage


def _base_state(stage: Stage) -> BaseState:
    sizes = {"position": 3, "quaternion": 4, "velocity": 3, "omega": 3, "alpha": 3}
    return BaseState(*(stage.reads("base", name, n) for name, n in sizes.items()))


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


def mirror(leg: str, v) -> tuple:
    """A vector between chassis axes and the leg frame."""
    sx, sy = MIRROR[leg]
    return v[0] * float(sx), v[1] * float(sy), v[2]


def mirror_spin(leg: str, v) -> tuple:
    """A pseudovector between chassis axes and the leg frame."""
    sx, sy = MIRROR[leg]
    return v[0] * float(sy), v[1] * float(sx), v[2] * float(sx * sy)


def reach(plant: Plant, h: float) -> Stage:
    """Eliminates a leg."""
    near = (*NEAR, *bank_stages.NEAR) if plant.effects else NEAR
    inputs, moved = _leg_arrays(plant)
    stage = Stage("reach", inputs | {"near": near}, {"reach": REACH} | moved)
    base = {name: stage.reads("near", name, 3) for name in ("omega", "omega_mid", "velocity", "normal")}
    base |= {"height": stage.read("near", "height"), "gravity": stage.read("param", "gravity")}
    ground = {name.removeprefix("contact_"): stage.read("param", name) for name in GROUND}
    more = {"pull": stage.reads("near", "pull", 3)} if plant.effects else {}
    r = reach_leg(
        _leg(plant, stage, h), _state(stage), stage.reads("drive", "drive", 2), _parameters(stage, plant), base, ground, h, **more
    )
    stage.write("reach", "soft_matrix", r.soft_matrix)
    stage.write("reach", "soft_rhs", r.soft_rhs)
    stage.write("reach", "free_matrix", r.free_matrix)
    stage.write("reach", "free_rhs", r.free_rhs)
    for name in ("soft_gain", "free_gain"):
        stage.write("reach", name, tuple(x for row in getattr(r, name) for x in row))
    stage.write("reach", "soft_own", r.soft_own)
    stage.write("reach", "free_own", r.free_own)
    stage.write("reach", "solve", r.solve)
    stage.write("reach", "jacobian", tuple(x for column in r.jacobian for x in column))
    stage.write("reach", "point", r.point)
    stage.write("reach", "contact", (r.contact.push, r.contact.grip, r.contact.slip, *r.contact.velocity))
    stage.write("reach", "stop", r.stop)
    return stage


def _read_reach(stage: Stage) -> Reach:
    def gain(name):
        flat = stage.reads("reach", name, 12)
        return flat[:6], flat[6:]

    jacobian = stage.reads("reach", "jacobian", 6)
    push, grip, slip, *velocity = stage.reads("reach", "contact", 6)
    contact = Contact(stage.reads("near", "normal", 3), push, grip, slip, tuple(velocity))
    return Reach(
        (), (), gain("soft_gain"), stage.reads("reach", "soft_own", 2), (), (), gain("free_gain"),
        stage.reads("reach", "free_own", 2), stage.reads("reach", "solve", 3), (jacobian[:3], jacobian[3:]),
        stage.reads("reach", "point", 3), contact, stage.reads("reach", "stop", 2),
    )  # fmt: skip


def _sum_legs(stage: Stage, array: str, name: str, n: int) -> tuple:
    """Sum over the legs of (n,) rows given in leg frames: a 6-vector or the lower triangle of a 6 x 6."""
    total = (0.0,) * n
    for leg in LEGS:
        signs = [*mirror_spin(leg, (1.0, 1.0, 1.0)), *mirror(leg, (1.0, 1.0, 1.0))]
        weights = signs if n == 6 else [signs[i] * signs[j] for i, j in ROW6]
        values = stage.reads(array, f"{leg}.{name}", n)
        total = vec.add(total, tuple(w * x for w, x in zip(weights, values, strict=True)))
    return total


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


def _write_increment(stage: Stage, array: str, increment) -> None:
    for leg in LEGS:
        stage.write(array, f"{leg}.increment", mirror_spin(leg, increment[:3]) + mirror(leg, increment[3:]))


def balance_soft(h: float, *, effects: bool = False) -> Stage:
    """First base solve, contact on the left-hand side."""
    pose = (*POSE, *bank_stages.POSE) if effects else POSE
    inputs = {"pose": pose, "body": BODY, "reach": by_leg(REACH)}
    stage = Stage("balance_soft", inputs, {"soft": by_leg(INCREMENT)})
    _write_increment(stage, "soft", _balance(stage, "soft", h))
    return stage


def grounded(plant: Plant, h: float) -> Stage:
    """What the ground really gives each foot."""
    inputs = {"param": parameter_rows(plant), "near": NEAR, "reach": REACH, "soft": INCREMENT}
    stage = Stage("grounded", inputs, {"grounded": GROUNDED})
    increment = stage.reads("soft", "increment", 6)
    r = _read_reach(stage)
    force = ground_force(r, increment, leg_increment(r.soft_own, r.soft_gain, increment), stage.read("param", "friction"))
    rhs, own = apply_ground(r, force, h)
    stage.write("grounded", "rhs", rhs)
    stage.write("grounded", "own", own)
    stage.write("grounded", "force", force)
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


def finish_legs(h: float) -> Stage:
    """New leg states from the base's final increment."""
    stage = Stage("finish_legs", {"state": STATE, "reach": REACH, "grounded": GROUNDED, "free": INCREMENT}, {"new_state": STATE})
    r = Reach((), (), (), (), (), (), (stage.reads("reach", "free_gain", 12)[:6], stage.reads("reach", "free_gain", 12)[6:]),
              stage.reads("reach", "free_own", 2), (), (), (), None, stage.reads("reach", "stop", 2))  # fmt: skip
    own = vec.add(r.free_own, stage.reads("grounded", "own", 2))
    new = finish(_state(stage), leg_increment(own, r.free_gain, stage.reads("free", "increment", 6)), h)
    _write_state(stage, new, r.stop)
    return stage
