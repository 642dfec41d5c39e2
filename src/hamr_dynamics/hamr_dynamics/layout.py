"""Row names: the layout of every array that the kernels touch, and how stages read and write a leg's rows.

Arrays (rows x lanes; leg lanes are leg-major: lane = leg * robots + robot, in the order of names.LEGS):
    state  leg lanes    q v a, stop counts
    drive  leg lanes    voltage minus neutral in the leg frame, or hip torque from a network
    param  leg lanes    what differs between lanes
    base   robot lanes  chassis state;   body  robot lanes  chassis parameters
A plant with effects has more rows behind some of these (`bank_stages`).
"""

from __future__ import annotations

from hamr_description.names import LEGS

from . import bank_stages
from .emit import Stage, rows
from .plant import Plant, flatten, unflatten
from .step import LegState

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


def read_parameters(stage: Stage, plant: Plant) -> dict:
    """A leg's parameters: those of the plant, with the rows that vary by lane in their place."""
    like = plant.parameters(LEGS[0])
    flat = {k: stage.read("param", k) if k in stage.inputs["param"] else x for k, x in flatten(like).items()}
    return unflatten(flat, like)


def read_state(stage: Stage) -> LegState:
    """A leg's state."""
    return LegState(*(stage.reads("state", name, 2) for name in "qva"))


def write_state(stage: Stage, state: LegState, stops: tuple) -> None:
    """A leg's new state, and its stop counts with (2,) hits more."""
    for name in "qva":
        stage.write("new_state", name, getattr(state, name))
    stage.write("new_state", "stops", tuple(n + s for n, s in zip(stage.reads("state", "stops", 2), stops, strict=True)))
