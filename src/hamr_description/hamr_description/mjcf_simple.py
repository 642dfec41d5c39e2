"""HAMR-simple as MuJoCo model: a rigid leg on a universal joint, from full's linear limit or as published."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping

import numpy as np

from . import mirror
from .mjcf_scene import add_capsule, add_foot, add_inertial, add_keyframes, control_range, neutral_foot, new, published_inertial
from .names import AXES, JOINTS, LEGS, MIRROR, torque_sign
from .numbers import leg_value, value
from .xml_tree import document, element

X, Y, Z = (1, 0, 0), (0, 1, 0), (0, 0, 1)


def simple(parameters: Mapping, *, environment: str = "ground", friction: float | None = None, gravity: bool = True) -> str:
    """MJCF of HAMR-simple: at each hip a hinge about x (lift), then one about z (swing), named as in names.JOINTS.

    Args:
        parameters: `chassis`, `front` and `rear` as in simple.yaml: mass g, com (3,) mm and inertia (6,) g mm^2 about it; for the
            legs in the front-left leg's frame about the hip, with (swing, lift) pairs of stiffness N mm/rad, damping N mm ms/rad
            and torque_per_volt N mm/V.
        environment, friction, gravity: as in mjcf_full.full.
    """
    scene = new("hamr_simple", chassis=parameters["chassis"], environment=environment, gravity=gravity)
    for leg in LEGS:
        constants = parameters[_end(leg)]
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
            _motor(scene.actuator, f"{leg}_{axis}", torque)
    add_keyframes(scene, joints=len(JOINTS), environment=environment)
    return document(scene.root)


def simple_published(*, environment: str = "ground", friction: float | None = None, gravity: bool = True) -> str:
    """MJCF of the published lumped fit: at each hip a hinge about y (swing), an almost massless link, a hinge about x (lift).

    Angles count from rest. The swing axis is +y on the left and -y on the right, so that a positive angle carries the foot the
    same way as in the other models and names.torque_sign holds. Arguments as in mjcf_full.full.
    """
    scene = new("hamr_simple_published", chassis=published_inertial("chassis"), environment=environment, gravity=gravity)
    springs = {axis: (value("simple_published.stiffness")[i], value("simple_published.damping")[i]) for i, axis in enumerate(AXES)}
    length, mass, inertia = (value(f"simple_published.{n}") for n in ("leg_length", "intermediate_mass", "intermediate_inertia"))
    for leg in LEGS:
        side = MIRROR[leg][1]
        half = side * value("simple_published.rest_lift") / 2
        yoke = element(scene.base, "body", name=f"{leg}_yoke", pos=mirror.point(leg, value("simple_published.hip")))
        add_inertial(yoke, {"mass": mass, "com": (0, 0, 0), "inertia": (inertia, inertia, inertia, 0, 0, 0)})
        _hinge(yoke, f"{leg}_swing", np.multiply(side, Y), *springs["swing"])
        body = element(yoke, "body", name=f"{leg}_leg", quat=(np.cos(half), np.sin(half), 0, 0))
        add_inertial(body, published_inertial(f"simple_published.{_end(leg)}"), leg)
        _hinge(body, f"{leg}_lift", X, *springs["lift"])
        add_capsule(body, (0, 0, 0), (0, 0, -length), radius=0.4, colour="leg")
        add_foot(scene, body, leg, (0, 0, -length), environment=environment, friction=friction)
        for axis in AXES:
            _motor(scene.actuator, f"{leg}_{axis}", value("simple_published.torque_per_volt"))
    add_keyframes(scene, joints=len(JOINTS), environment=environment)
    return document(scene.root)


def _end(leg: str) -> str:
    return "front" if leg.startswith("f") else "rear"


def _hinge(body: ET.Element, name: str, axis, stiffness: float, damping: float) -> None:
    element(body, "joint", name=name, type="hinge", axis=axis, stiffness=stiffness, damping=damping)


def _motor(actuator: ET.Element, joint: str, torque_per_volt: float) -> None:
    """Hip torque linear in the drive voltage, zero at neutral."""
    gain = torque_sign(joint) * torque_per_volt
    element(actuator, "general", name=f"{joint}_actuator", joint=joint, ctrlrange=control_range(), gainprm=gain,
            biastype="affine", biasprm=(-gain * value("actuator.neutral_voltage"), 0, 0))
