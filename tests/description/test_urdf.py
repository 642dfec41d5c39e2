"""The URDF as an XML tree: eight revolute joints, masses, SI units, and feet where the robot has them."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import mujoco
import numpy as np
import pytest

from hamr_description import mjcf, urdf
from hamr_description.mjcf_full import drive_joint
from hamr_description.names import BASE_FRAME, JOINTS, LEGS
from hamr_sim_full.mujoco_full import hip_rows
from hamr_sim_full.mujoco_oracle import close_loops


@pytest.fixture(scope="module")
def robot() -> ET.Element:
    return ET.fromstring(urdf.build())


def vector(node: ET.Element, key: str) -> np.ndarray:
    return np.array([float(x) for x in node.get(key).split()])


def turn(axis: np.ndarray, angle: float) -> np.ndarray:
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def place(robot: ET.Element, link: str, angles: dict[str, float]) -> np.ndarray:
    """Origin of a link in base_link, m, by walking up the tree."""
    parents = {joint.find("child").get("link"): joint for joint in robot.iter("joint")}
    point = np.zeros(3)
    while link != BASE_FRAME:
        joint = parents[link]
        if joint.get("type") == "revolute":
            point = turn(vector(joint.find("axis"), "xyz"), angles.get(joint.get("name"), 0.0)) @ point
        point = point + vector(joint.find("origin"), "xyz")
        link = joint.find("parent").get("link")
    return point


def test_tree_has_eight_revolute_joints_by_name(robot):
    revolute = [joint.get("name") for joint in robot.iter("joint") if joint.get("type") == "revolute"]
    assert sorted(revolute) == sorted(JOINTS)
    links = {link.get("name") for link in robot.iter("link")}
    children = [joint.find("child").get("link") for joint in robot.iter("joint")]
    assert len(children) == len(set(children))
    assert links - set(children) == {BASE_FRAME}


def test_masses_add_up_to_the_robot(robot):
    assert sum(float(mass.get("value")) for mass in robot.iter("mass")) == pytest.approx(1.47499e-3, abs=1e-8)


def test_inertias_are_positive_and_of_the_robots_size(robot):
    for node in robot.iter("inertia"):
        ixx, iyy, izz, ixy, ixz, iyz = (float(node.get(key)) for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"))
        moments = np.linalg.eigvalsh([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
        assert (moments > 1e-10).all() and (moments < 1.1e-7).all(), "kg m^2"


@pytest.mark.parametrize("swing", [-0.3, 0.0, 0.4])
@pytest.mark.parametrize("lift", [-0.2, 0.0, 0.3])
def test_feet(robot, swing, lift):
    """hip + Rx(lift) Rz(swing) (0, +-7.58, -13.0) mm; at rest (12.755, 17.37, -12.54) mirrored."""
    for leg, sx, sy in (("fl", 1, 1), ("rl", -1, 1), ("fr", 1, -1), ("rr", -1, -1)):
        leg_vector = turn(np.array([1, 0, 0]), lift) @ turn(np.array([0, 0, 1]), swing) @ (0.0, sy * 7.58, -13.0)
        foot = 1e3 * place(robot, f"{leg}_foot", {f"{leg}_swing": swing, f"{leg}_lift": lift})
        assert foot == pytest.approx(np.array([sx * 12.75466, sy * 9.79, 0.46]) + leg_vector, abs=1e-5)


def hips_at_stops(side: float) -> np.ndarray:
    """(8,) hip angles of HAMR-full in MuJoCo with each slider in turn at side * 0.3 mm, the leg's other hip angle at rest."""
    model = mujoco.MjModel.from_xml_string(mjcf.full(c0=0.0, c1=0.0, environment="suspended"))
    hips = hip_rows(model)
    found = np.empty(8)
    for axis in (0, 1):
        data = mujoco.MjData(model)
        held = np.zeros((8, model.nv))
        for i in range(8):
            held[i] = hips[i] if i % 2 != axis else np.eye(model.nv)[model.joint(drive_joint(JOINTS[i])).dofadr[0]]
        for part in (0.3, 0.6, 1.0):
            close_loops(model, data, held, part * side * 0.3 * (np.arange(8) % 2 == axis), np.zeros(8))
        found[axis::2] = (hips @ data.qpos)[axis::2]
    return found


def test_limits_are_where_the_sliders_meet_their_stops(robot):
    limits = {joint.get("name"): joint.find("limit") for joint in robot.iter("joint") if joint.get("type") == "revolute"}
    found = [[float(limits[joint].get(end)) for end in ("lower", "upper")] for joint in JOINTS]
    assert found == pytest.approx(np.sort(np.stack([hips_at_stops(-1), hips_at_stops(1)], axis=1)), abs=1e-5)


def test_full_drive_is_the_largest_effort(robot):
    """0.3243 N blocked over 0.53 and 0.58 mm/rad of slider per hip angle."""
    efforts = {
        joint.get("name"): float(joint.find("limit").get("effort")) for joint in robot.iter("joint") if joint.find("limit") is not None
    }
    for leg in LEGS:
        assert efforts[f"{leg}_swing"] == pytest.approx(0.3243e-3 * 0.53, rel=1e-3)
        assert efforts[f"{leg}_lift"] == pytest.approx(0.3243e-3 * 0.58, rel=1e-3)


def test_every_leg_is_drawn(robot):
    drawn = {link.get("name") for link in robot.iter("link") if link.find("visual") is not None}
    assert drawn == {BASE_FRAME, *(f"{leg}_leg" for leg in LEGS)}
