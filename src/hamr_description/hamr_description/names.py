"""Names and orders: the only place where a joint, link, topic, frame or service is spelled.

Order of the joints everywhere: leg by leg (`fl rl fr rr`), swing before lift.
"""

from __future__ import annotations

LEGS = ("fl", "rl", "fr", "rr")
AXES = ("swing", "lift")
JOINTS = tuple(f"{leg}_{axis}" for leg in LEGS for axis in AXES)
ACTUATORS = tuple(f"{joint}_actuator" for joint in JOINTS)

#: Mirror of each leg against the front-left one: signs of (x, y). Points map by (sx*x, sy*y, z).
MIRROR = {"fl": (1, 1), "rl": (-1, 1), "fr": (1, -1), "rr": (-1, -1)}

BASE_FRAME = "base_link"
WORLD_FRAME = "odom"


class Topic:
    """Topic names (see docs/topics.md for types and content)."""

    CLOCK = "/clock"
    JOINT_STATES = "/joint_states"
    ODOM = "/odom"
    LEG_TARGETS = "/leg_targets"
    CMD_VEL = "/cmd_vel"
    SERVO_JOINTS = "/servo/joints"
    SERVO_ACTUATORS = "/servo/actuators"
    SERVO_VOLTAGES = "/servo/voltages"
    DIAGNOSTICS = "/diagnostics"
    RUN_INFO = "/run_info"
    ROBOT_DESCRIPTION = "/robot_description"


def joint_signs(leg: str) -> tuple[int, int]:
    """Signs that take a leg's (swing, lift) angles into the mirrored front-left leg's.

    Angles are pseudovectors: about z they flip with sx*sy, about x with sy.
    """
    sx, sy = MIRROR[leg]
    return sx * sy, sy


def drive_sign(leg: str) -> int:
    """Sign of (V - neutral) seen in the mirrored front-left leg (actuator orientation, REPO)."""
    sx, sy = MIRROR[leg]
    return sx * sy


def torque_sign(joint: str) -> int:
    """Sign of hip torque per volt of a joint: + for every swing, + - + - for the lifts of fl rl fr rr."""
    leg, axis = joint.split("_")
    swing, lift = joint_signs(leg)
    return drive_sign(leg) * (swing if axis == "swing" else lift)
