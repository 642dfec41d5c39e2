"""What all MuJoCo models share: options, base, feet with their contact, and keyframes (g, mm, ms, N, V)."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from . import mirror
from .errors import ConfigError
from .mjcf_looks import COLOURS, FLOOR, add_chassis_shape, add_looks, add_stage
from .names import ACTUATORS, BASE_FRAME
from .numbers import value
from .posture import hang_height, stand_height
from .rates import SERVO_MS
from .xml_tree import element

ENVIRONMENTS = ("ground", "suspended")
#: Radius of the foot spheres, mm. The floor lies that much deeper, so that contact begins where the foot point crosses z = 0.
FOOT_RADIUS = 1e-3
# Constraint errors decay within two steps. Loops are as hard as MuJoCo allows. Feet are a hundred times softer, which halves the
# cost of slipping feet; still a standing foot sinks 1e-5 mm and creeps 2e-5 mm/ms.
SOLREF = (2 * SERVO_MS, 1.0)
LOOP_SOLIMP = (0.9999, 0.9999, 1e-3, 0.5, 2.0)
FOOT_SOLIMP = (0.99, 0.99, 1e-3, 0.5, 2.0)


@dataclass(frozen=True, slots=True)
class Scene:
    """A model under construction: the document and the places where parts are added."""

    root: ET.Element
    base: ET.Element
    contact: ET.Element
    equality: ET.Element
    actuator: ET.Element


def new(name: str, *, chassis: Mapping, environment: str, gravity: float | None) -> Scene:
    """Scene with a floor and the chassis (mass, com, inertia), which floats on the `ground` and is fixed when `suspended`."""
    if environment not in ENVIRONMENTS:
        raise ConfigError(f"MJCF model: environment '{environment}' is unknown; choose one of {', '.join(ENVIRONMENTS)}.")
    root = element(None, "mujoco", model=name)
    element(root, "compiler", angle="radian", autolimits=True, inertiafromgeom=False, boundmass=0, boundinertia=0)
    pull = (0, 0, -(value("robot.gravity") if gravity is None else gravity))
    solver = {"solver": "Newton", "cone": "elliptic", "jacobian": "dense", "iterations": 30, "tolerance": 1e-12}
    element(root, "option", timestep=SERVO_MS, gravity=pull, integrator="Euler", **solver)
    add_looks(root)
    world = element(root, "worldbody")
    add_stage(world)
    depth = (0, 0, -FOOT_RADIUS)
    element(world, "geom", name=FLOOR, type="plane", pos=depth, size=(0, 0, 1), material=FLOOR, contype=0, conaffinity=0)
    floating = environment == "ground"
    base = element(world, "body", name=BASE_FRAME, pos=(0, 0, stand_height() if floating else hang_height()))
    if floating:
        element(base, "freejoint", name=BASE_FRAME)
    add_inertial(base, chassis)
    add_chassis_shape(base)
    element(base, "site", name=BASE_FRAME, size=0.3)
    return Scene(root, base, element(root, "contact"), element(root, "equality"), element(root, "actuator"))


def add_foot(scene: Scene, body: ET.Element, leg: str, position, *, environment: str, friction: float | None) -> None:
    """Site and contact sphere of a foot at `position` (3,) mm in `body`; on the ground, its pair with the floor."""
    foot = f"{leg}_foot"
    element(body, "site", name=foot, pos=position, size=0.3, rgba=COLOURS["foot"])
    element(body, "geom", name=foot, type="sphere", size=FOOT_RADIUS, pos=position, mass=0, contype=0, conaffinity=0, group=3)
    if environment == "ground":
        mu = value("contact.friction") if friction is None else friction
        law = {"friction": (mu, mu, 0, 0, 0), "solref": SOLREF, "solimp": FOOT_SOLIMP}
        element(scene.contact, "pair", name=foot, geom1=FLOOR, geom2=foot, condim=3, **law)


def published_inertial(group: str) -> dict:
    """Mass, com and inertia of a group of numbers.yaml."""
    return {name: value(f"{group}.{name}") for name in ("mass", "com", "inertia")}


def add_inertial(body: ET.Element, inertial: Mapping, leg: str | None = None) -> None:
    """`mass` g, `com` (3,) mm and `inertia` (6,) g mm^2 about it; of a leg's part, mirrored from the front-left leg."""
    com, inertia = inertial["com"], inertial["inertia"]
    if leg:
        com, inertia = mirror.point(leg, com), mirror.inertia(leg, inertia)
    element(body, "inertial", mass=inertial["mass"], pos=com, fullinertia=inertia)


def add_keyframes(scene: Scene, *, joints: int, environment: str) -> None:
    """`stand` (feet just touching) and `suspended`, joints at rest, drives neutral. A fixed chassis hangs in both."""
    keys = element(scene.root, "keyframe")
    for name, height in (("stand", stand_height()), ("suspended", hang_height())):
        base = (0, 0, height, 1, 0, 0, 0) if environment == "ground" else ()
        ctrl = np.full(len(ACTUATORS), value("actuator.neutral_voltage"))
        element(keys, "key", name=name, qpos=(*base, *np.zeros(joints)), ctrl=ctrl)


def control_range() -> tuple[float, float]:
    """Range of a drive voltage, V."""
    return value("actuator.ground_voltage"), value("actuator.bias_voltage")
