"""HAMR-simple as MuJoCo model: a rigid leg on a universal joint, from full's linear limit or as published."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping

from . import mirror
from .mjcf_looks import add_capsule
from .mjcf_scene import add_foot, add_inertial, add_keyframes, control_range, new, published_inertial
from .names import AXES, JOINTS, LEGS, MIRROR, drive_sign, torque_sign
from .numbers import leg_value, value
from .posture import neutral_foot
from .xml_tree import document, element

X, Y, Z = (1, 0, 0), (0, 1, 0), (0, 0, 1)


def simple(parameters: Mapping, *, environment: str = "ground", friction: float | None = None, gravity: float | None = None) -> str:
    """MJCF of HAMR-simple: at each hip a hinge about x (lift), then one about z (swing), named as in names.JOINTS.

    Args:
        parameters: `chassis`, `front` and `rear` as in simple.yaml: mass g, com (3,) mm and inertia (6,) g mm^2 about it; for the
            legs in the front-left leg's frame about the hip, with (swing, lift) pairs of stiffness N mm/rad, damping N mm ms/rad
            and torque_per_volt N mm/V.
        environment, friction, gravity: as in mjcf_full.full.
    """
    scene = new("hamr_simple", chassis=parameters["chassis"], environment=environment, gravity=gravity)
    for leg in LEGS:
        constants = parameters[mirror.end(leg)]
        hip = mirror.point(leg, leg_value(leg, "hip"))
        body = element(scene.base, "body", name=f"{leg}_leg", pos=hip)
        add_inertial(body, constants, leg)
        springs = {axis: (constants["stiffness"][i], constants["damping"][i]) for i, axis in enumerate(AXES)}
        _hinge(body, f"{leg}_lift", X, *springs["lift"])
        _hinge(body, f"{leg}_swing", Z, *springs["swing"])
        foot = neutral_foot(leg) - hip
        add_capsule(body, (0, 0, 0), (0, foot[1], 0), radius=0.4, colour="leg")
        add_capsule(body, (0, foot[1], 0), foot, radius=0.4, colour="leg")
        add_foot(scene, body, leg, foot, environment=environment, friction=friction)
        for axis, torque in zip(AXES, constants["torque_per_volt"], strict=True):
            joint = f"{leg}_{axis}"
            _motor(scene.actuator, joint, joint, torque_sign(joint) * torque)
    add_keyframes(scene, joints=len(JOINTS), environment=environment)
    return document(scene.root)


def published_hinge(joint: str) -> str:
    """The published fit's own hinge that the drive of `joint` turns; its angle is no hip angle."""
    return f"{joint}_hinge"


def simple_published(*, environment: str = "ground", friction: float | None = None, gravity: float | None = None) -> str:
    """MJCF of the published lumped fit: at each hip a hinge about y (swing), an almost massless link, a hinge about x (lift).

    Hinge angles count from rest; hamr_sim_residual.mujoco_published reads them as hip angles. Arguments as in mjcf_full.full.
    """
    scene = new("hamr_simple_published", chassis=published_inertial("chassis"), environment=environment, gravity=gravity)
    springs = {axis: (value("simple_published.stiffness")[i], value("simple_published.damping")[i]) for i, axis in enumerate(AXES)}
    length, mass, inertia = (value(f"simple_published.{n}") for n in ("leg_length", "intermediate_mass", "intermediate_inertia"))
    for leg in LEGS:
        sx, sy = MIRROR[leg]
        half = sy * value("simple_published.rest_lift") / 2
        yoke = element(scene.base, "body", name=f"{leg}_yoke", pos=mirror.point(leg, value("simple_published.hip")))
        add_inertial(yoke, {"mass": mass, "com": (0, 0, 0), "inertia": (inertia, inertia, inertia, 0, 0, 0)})
        _hinge(yoke, published_hinge(f"{leg}_swing"), Y, *springs["swing"])
        body = element(yoke, "body", name=f"{leg}_leg", quat=(math.cos(half), math.sin(half), 0, 0))
        add_inertial(body, published_inertial(f"simple_published.{mirror.end(leg)}"), leg)
        _hinge(body, published_hinge(f"{leg}_lift"), X, *springs["lift"])
        add_capsule(body, (0, 0, 0), (0, 0, -length), radius=0.4, colour="leg")
        add_foot(scene, body, leg, (0, 0, -length), environment=environment, friction=friction)
        for axis, sign in zip(AXES, (sx, sy), strict=True):  # mirror signs of angles about y and x
            joint = f"{leg}_{axis}"
            _motor(scene.actuator, joint, published_hinge(joint), sign * drive_sign(leg) * value("simple_published.torque_per_volt"))
    add_keyframes(scene, joints=len(JOINTS), environment=environment)
    return document(scene.root)


def _hinge(body: ET.Element, name: str, axis, stiffness: float, damping: float) -> None:
    element(body, "joint", name=name, type="hinge", axis=axis, stiffness=stiffness, damping=damping)


def _motor(actuator: ET.Element, joint: str, hinge: str, torque_per_volt: float) -> None:
    """Torque on a hinge, linear in the drive voltage and zero at neutral."""
    law = {"gainprm": torque_per_volt, "biastype": "affine", "biasprm": (-torque_per_volt * value("actuator.neutral_voltage"), 0, 0)}
    element(actuator, "general", name=f"{joint}_actuator", joint=hinge, ctrlrange=control_range(), **law)
