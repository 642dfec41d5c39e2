"""HAMR-full as MuJoCo model: two serial chains per leg and three loop closures (numbers.yaml, group `leg`)."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from . import mirror
from .mjcf_looks import add_capsule
from .mjcf_scene import LOOP_SOLIMP, SOLREF, Scene, add_foot, add_inertial, add_keyframes, control_range, new, published_inertial
from .names import AXES, BASE_FRAME, JOINTS, LEGS, MIRROR, drive_sign
from .numbers import leg_value, value
from .xml_tree import document, element

#: Joint and child link of each chain, from the chassis outward.
CHAINS = {
    "swing": (("swing_slider", "S1"), ("s1", "S2"), ("s2", "S3"), ("fb1", "S4")),
    "lift": (("lift_slider", "L1"), ("l1", "L2"), ("l2", "L3"), ("fb3", "L4")),
}
X, Y, Z = (1, 0, 0), (0, 1, 0), (0, 0, 1)
#: Joint axes, the same on all legs.
AXIS = {"swing_slider": Y, "s1": Z, "s2": Z, "fb1": X, "lift_slider": Y, "l1": X, "l2": X, "fb3": Z}
#: The two links that each closure joins; None is the chassis.
CLOSURES = {"s3": (None, "S3"), "l3": (None, "L3"), "fb2": ("S4", "L4")}


def hip_joints(joint: str) -> tuple[str, ...]:
    """The model's joints whose angles add up to a hip angle."""
    leg, axis = joint.split("_")
    return (f"{leg}_fb3",) if axis == "swing" else (f"{leg}_l1", f"{leg}_l2")


def drive_joint(joint: str) -> str:
    """The slider that drives a hip angle."""
    return f"{joint}_slider"


def full(
    *, c0: float, c1: float, environment: str = "ground", friction: float | None = None, rail: bool = True, gravity: float | None = None
) -> str:
    """MJCF of HAMR-full, 50 us steps, `ctrl` = drive voltages in V.

    Args:
        c0, c1: force per volt of one actuator layer, N/V, and its change with deflection, N/(V mm) (hamr_sim_full.actuator).
        environment: `ground` (floating chassis, foot contact) or `suspended` (chassis fixed, no contact).
        friction: Coulomb coefficient of the feet; None takes contact.friction.
        rail: with the force of the bias rail, c1 (Vb - Vg) per mm; False gives the published "rail off" figures.
        gravity: mm/ms^2; None takes robot.gravity.

    End stops are no MuJoCo limits: they are forces on the sliders that hamr_sim_full.mujoco_engine adds.
    """
    scene = new("hamr_full", chassis=published_inertial("chassis"), environment=environment, gravity=gravity)
    for leg in LEGS:
        links: dict[str | None, ET.Element] = {None: scene.base}
        for axis in AXES:
            links |= _chain(scene.base, leg, axis)
        _close(scene, leg, links)
        _draw(leg, links)
        add_foot(scene, links["L4"], leg, mirror.point(leg, leg_value(leg, "foot_in_L4")), environment=environment, friction=friction)
    for joint in JOINTS:
        _actuate(scene.actuator, joint, c0, c1 if rail else 0.0)
    add_keyframes(scene, joints=len(AXIS) * len(LEGS), environment=environment)
    return document(scene.root)


def _chain(base: ET.Element, leg: str, axis: str) -> dict[str, ET.Element]:
    links, parent = {}, base
    for joint, link in CHAINS[axis]:
        parent = links[link] = element(parent, "body", name=f"{leg}_{link}", pos=mirror.point(leg, leg_value(leg, f"origins.{joint}")))
        add_inertial(parent, {name: leg_value(leg, f"links.{link}.{name}") for name in ("mass", "com", "inertia")}, leg)
        slider = joint.endswith("slider")
        spring = "actuator" if slider else f"leg.flexures.{joint}"
        law = {name: value(f"{spring}.{name}") for name in ("stiffness", "damping")}
        element(parent, "joint", name=f"{leg}_{joint}", type="slide" if slider else "hinge", axis=AXIS[joint], **law)
    return links


def _close(scene: Scene, leg: str, links: dict[str | None, ET.Element]) -> None:
    for closure, bodies in CLOSURES.items():
        sites = [f"{leg}_{closure}_{link or BASE_FRAME}" for link in bodies]
        for site, link, point in zip(sites, bodies, leg_value(leg, f"closures.{closure}"), strict=True):
            element(links[link], "site", name=site, pos=mirror.point(leg, point), size=0.15, group=4)
        element(scene.equality, "connect", name=f"{leg}_{closure}", site1=sites[0], site2=sites[1], solref=SOLREF, solimp=LOOP_SOLIMP)


def _actuate(actuator: ET.Element, joint: str, c0: float, c1: float) -> None:
    """F = s c0 (Vb + Vg - 2 V) - c1 (Vb - Vg) q along the slider.

    In the front-left leg a voltage above neutral pushes the slider along +y, so s = -1; elsewhere the signs of drive and y follow.
    """
    leg = joint.split("_")[0]
    s = -MIRROR[leg][1] * drive_sign(leg)
    ground, bias = control_range()
    law = {"gainprm": -2 * s * c0, "biastype": "affine", "biasprm": (s * c0 * (bias + ground), -c1 * (bias - ground), 0)}
    element(actuator, "general", name=f"{joint}_actuator", joint=drive_joint(joint), ctrlrange=(ground, bias), **law)


def _draw(leg: str, links: dict[str | None, ET.Element]) -> None:
    """Bars along the links: couplers and cranks thin, the leg thick down to the foot."""

    def at(path: str, row: int | None = None):
        points = leg_value(leg, path)
        return mirror.point(leg, points if row is None else points[row])

    zero = (0.0, 0.0, 0.0)
    for axis, closure in (("swing", "s3"), ("lift", "l3")):
        (_, slider), (first, coupler), (second, crank), (last, _) = CHAINS[axis]
        add_capsule(links[slider], zero, at(f"origins.{first}"), radius=0.35, colour=axis)
        add_capsule(links[coupler], zero, at(f"origins.{second}"), radius=0.25, colour=axis)
        add_capsule(links[crank], at(f"closures.{closure}", 1), zero, radius=0.3, colour=axis)
        add_capsule(links[crank], zero, at(f"origins.{last}"), radius=0.3, colour=axis)
    add_capsule(links["S4"], zero, at("closures.fb2", 0), radius=0.3, colour="swing")
    knee, foot = at("closures.fb2", 1), at("foot_in_L4")
    add_capsule(links["L4"], zero, knee, radius=0.4, colour="leg")
    add_capsule(links["L4"], knee, foot, radius=0.4, colour="leg")
