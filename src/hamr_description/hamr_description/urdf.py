"""URDF of the 4 x 2 joint tree for viewers (`/robot_description`), in SI units."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping

import numpy as np

from . import mirror
from .mjcf_looks import COLOURS
from .names import AXES, BASE_FRAME, LEGS, joint_signs
from .numbers import leg_value, value
from .posture import neutral_foot
from .rates import TARGET_MS
from .simple_constants import simple_constants
from .units import inertia_to_si, length_to_si, mass_to_si, rate_to_si, torque_to_si
from .xml_tree import document, element

LEG_RADIUS = 0.4  # as drawn, mm


def build(parameters: Mapping | None = None) -> str:
    """URDF: base_link; per leg the lift joint about x at the hip, the swing joint about z, and the foot's frame.

    Args:
        parameters: constants of HAMR-simple (simple_constants.py); None takes the packaged ones.

    Limits are the end stops, the largest effort is that of full drive, the velocity limit crosses the range in one target period.
    """
    parameters = simple_constants() if parameters is None else parameters
    robot = element(None, "robot", name="hamr")
    for name in ("hull", "leg", "foot"):
        element(element(robot, "material", name=name), "color", rgba=COLOURS[name])
    base = element(robot, "link", name=BASE_FRAME)
    _inertial(base, parameters["chassis"])
    low, high = value("robot.chassis_z_range")
    length, width, _ = value("robot.chassis_size")
    _box(base, (0, 0, (low + high) / 2), (length, width, high - low), "hull")
    for leg in LEGS:
        _leg(robot, leg, parameters[mirror.end(leg)])
    return document(robot)


def _leg(robot: ET.Element, leg: str, constants: Mapping) -> None:
    hip = mirror.point(leg, leg_value(leg, "hip"))
    foot = neutral_foot(leg) - hip
    element(robot, "link", name=f"{leg}_yoke")
    body = element(robot, "link", name=f"{leg}_leg")
    element(robot, "link", name=f"{leg}_foot")
    _inertial(
        body, {"mass": constants["mass"], "com": mirror.point(leg, constants["com"]), "inertia": mirror.inertia(leg, constants["inertia"])}
    )
    thick = 2 * LEG_RADIUS
    _box(body, (0, foot[1] / 2, 0), (thick, abs(foot[1]), thick), "leg")
    _box(body, (0, foot[1], foot[2] / 2), (thick, thick, abs(foot[2])), "leg")
    _ball(body, foot, "foot")
    _revolute(robot, leg, "lift", (1, 0, 0), hip, (BASE_FRAME, f"{leg}_yoke"), constants)
    _revolute(robot, leg, "swing", (0, 0, 1), (0, 0, 0), (f"{leg}_yoke", f"{leg}_leg"), constants)
    _joint(robot, f"{leg}_foot", "fixed", foot, (f"{leg}_leg", f"{leg}_foot"))


def _revolute(robot: ET.Element, leg: str, axis: str, direction, origin, links: tuple[str, str], constants: Mapping) -> None:
    i = AXES.index(axis)
    low, high = sorted(joint_signs(leg)[i] * constants[stop][i] for stop in ("stop_low", "stop_high"))
    joint = _joint(robot, f"{leg}_{axis}", "revolute", origin, links)
    element(joint, "axis", xyz=direction)
    element(
        joint,
        "limit",
        lower=low,
        upper=high,
        velocity=rate_to_si((high - low) / TARGET_MS),
        effort=torque_to_si(constants["torque_per_volt"][i] * value("actuator.neutral_voltage")),
    )


def _joint(robot: ET.Element, name: str, kind: str, origin, links: tuple[str, str]) -> ET.Element:
    joint = element(robot, "joint", name=name, type=kind)
    element(joint, "origin", xyz=length_to_si(np.asarray(origin, float)))
    element(joint, "parent", link=links[0])
    element(joint, "child", link=links[1])
    return joint


def _inertial(link: ET.Element, inertial: Mapping) -> None:
    inertia = inertia_to_si(np.asarray(inertial["inertia"], float))
    node = element(link, "inertial")
    element(node, "origin", xyz=length_to_si(np.asarray(inertial["com"], float)))
    element(node, "mass", value=mass_to_si(inertial["mass"]))
    element(node, "inertia", **dict(zip(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), inertia.tolist(), strict=True)))


def _visual(link: ET.Element, origin, material: str) -> ET.Element:
    visual = element(link, "visual")
    element(visual, "origin", xyz=length_to_si(np.asarray(origin, float)))
    geometry = element(visual, "geometry")
    element(visual, "material", name=material)
    return geometry


def _box(link: ET.Element, origin, size, material: str) -> None:
    element(_visual(link, origin, material), "box", size=length_to_si(np.asarray(size, float)))


def _ball(link: ET.Element, origin, material: str) -> None:
    element(_visual(link, origin, material), "sphere", radius=length_to_si(2 * LEG_RADIUS))
