"""What all MuJoCo models share: options, looks, floor, cameras, base, feet, contact and keyframes (g, mm, ms, N, V)."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from . import mirror
from .errors import ConfigError
from .names import BASE_FRAME, LEGS
from .numbers import leg_value, value
from .rates import SERVO_MS
from .xml_tree import element

ENVIRONMENTS = ("ground", "suspended")
FLOOR = "floor"
#: Radius of the foot spheres, mm. The floor lies that much deeper, so that contact begins where the foot point crosses z = 0.
FOOT_RADIUS = 1e-3
# Constraints are as hard as MuJoCo allows: error decays within two steps, impedance at its cap.
SOLREF = (2 * SERVO_MS, 1.0)
SOLIMP = (0.9999, 0.9999, 1e-3, 0.5, 2.0)
COLOURS = {"hull": (0.35, 0.40, 0.48, 0.25), "frame": (0.15, 0.16, 0.18, 1.0), "board": (0.10, 0.38, 0.25, 1.0), "swing": (0.91, 0.55, 0.13, 1.0),
           "lift": (0.18, 0.52, 0.80, 1.0), "leg": (0.86, 0.87, 0.89, 1.0), "foot": (0.80, 0.12, 0.15, 1.0)}


@dataclass(frozen=True, slots=True)
class Scene:
    """A model under construction: the document and the places where parts are added."""

    root: ET.Element
    world: ET.Element
    base: ET.Element
    contact: ET.Element
    equality: ET.Element
    actuator: ET.Element


def stand_height() -> float:
    """Height of the chassis frame with neutral feet just touching, mm."""
    return -float(neutral_foot("fl")[2])


def neutral_foot(leg: str) -> np.ndarray:
    """Foot in the chassis frame at rest (3,), mm: down the lift chain."""
    chain = sum(leg_value(leg, f"origins.{joint}") for joint in ("lift_slider", "l1", "l2", "fb3"))
    return mirror.point(leg, chain + leg_value(leg, "foot_in_L4"))


def new(name: str, *, chassis: Mapping, environment: str, gravity: bool) -> Scene:
    """Scene with a floor and the chassis (mass, com, inertia), which floats on the `ground` and is fixed when `suspended`."""
    if environment not in ENVIRONMENTS:
        raise ConfigError(f"MJCF model: environment '{environment}' is unknown; choose one of {', '.join(ENVIRONMENTS)}.")
    root = element(None, "mujoco", model=name)
    element(root, "compiler", angle="radian", autolimits=True, inertiafromgeom=False, boundmass=0, boundinertia=0)
    element(root, "option", timestep=SERVO_MS, gravity=(0, 0, -value("robot.gravity") if gravity else 0), integrator="Euler",
                     solver="Newton", cone="elliptic", jacobian="dense", iterations=30, tolerance=1e-12)
    _looks(root)
    world = element(root, "worldbody")
    _surroundings(world)
    base = _chassis(world, chassis, environment)
    return Scene(root, world, base, element(root, "contact"), element(root, "equality"), element(root, "actuator"))


def add_foot(scene: Scene, body: ET.Element, leg: str, position, *, environment: str, friction: float | None) -> None:
    """Site and contact sphere of a foot at `position` (3,) mm in `body`; on the ground, its pair with the floor."""
    element(body, "site", name=f"{leg}_foot", pos=position, size=0.3, rgba=COLOURS["foot"])
    element(body, "geom", name=f"{leg}_foot", type="sphere", size=FOOT_RADIUS, pos=position, mass=0, contype=0, conaffinity=0, group=3)
    if environment == "ground":
        mu = value("contact.friction") if friction is None else friction
        element(scene.contact, "pair", name=f"{leg}_foot", geom1=FLOOR, geom2=f"{leg}_foot", condim=3, friction=(mu, mu, 0, 0, 0),
                solref=SOLREF, solimp=SOLIMP)


def add_capsule(body: ET.Element, start, end, *, radius: float, colour: str) -> None:
    """A link as seen, without mass and contact."""
    if np.linalg.norm(np.subtract(end, start)) > 0:
        element(body, "geom", type="capsule", fromto=(*start, *end), size=radius, rgba=COLOURS[colour], mass=0, contype=0, conaffinity=0, group=1)


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
    """`stand` (feet just touching) and `suspended` (twice as high), joints at rest, drives neutral. A fixed chassis stays where it hangs."""
    keys = element(scene.root, "keyframe")
    for name, height in (("stand", stand_height()), ("suspended", _hang_height())):
        base = (0, 0, height, 1, 0, 0, 0) if environment == "ground" else ()
        element(keys, "key", name=name, qpos=(*base, *np.zeros(joints)), ctrl=np.full(2 * len(LEGS), value("actuator.neutral_voltage")))


def control_range() -> tuple[float, float]:
    """Range of a drive voltage, V."""
    return value("actuator.ground_voltage"), value("actuator.bias_voltage")


def _hang_height() -> float:
    return 2 * stand_height()


def _chassis(world: ET.Element, inertial: Mapping, environment: str) -> ET.Element:
    length, width, height = value("robot.chassis_size")
    low, high = value("robot.chassis_z_range")
    board = 0.05 * height
    base = element(world, "body", name=BASE_FRAME, pos=(0, 0, stand_height() if environment == "ground" else _hang_height()))
    if environment == "ground":
        element(base, "freejoint", name=BASE_FRAME)
    add_inertial(base, inertial)
    half, middle = np.divide((length, width, high - low), 2), np.array((0, 0, (low + high) / 2))
    _box(base, middle, half, "hull")
    _box(base, (0, 0, high - 2 * board), (0.46 * length, 0.4 * width, board / 2), "board")
    _box(base, (length / 2, 0, 0.7 * high), (0.2, 0.2 * width, 0.1 * height), "foot")  # marks the front
    for axis, (u, v) in enumerate(((1, 2), (0, 2), (0, 1))):  # the box's edges
        for su, sv in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            start = np.zeros(3)
            start[[axis, u, v]] = half[axis], su * half[u], sv * half[v]
            end = start.copy()
            end[axis] = -half[axis]
            add_capsule(base, middle + start, middle + end, radius=0.25, colour="frame")
    return base


def _box(body: ET.Element, centre, half, colour: str) -> None:
    element(body, "geom", type="box", pos=centre, size=half, rgba=COLOURS[colour], mass=0, contype=0, conaffinity=0, group=1)


def _looks(root: ET.Element) -> None:
    length = value("robot.body_length")
    element(root, "statistic", extent=1.5 * length, center=(0, 0, stand_height()), meansize=0.1 * length)
    visual = element(root, "visual")
    element(visual, "global", azimuth=130, elevation=-20, offwidth=1920, offheight=1080)
    element(visual, "map", znear=0.01, zfar=50, shadowscale=0.9, force=200, torque=20)
    element(visual, "headlight", ambient=(0.3, 0.3, 0.3), diffuse=(0.3, 0.3, 0.3), specular=(0.1, 0.1, 0.1))
    element(visual, "quality", shadowsize=4096)
    element(visual, "scale", contactwidth=0.1, contactheight=0.02, forcewidth=0.05)
    asset = element(root, "asset")
    element(asset, "texture", name="sky", type="skybox", builtin="gradient", rgb1=(0.92, 0.95, 0.98), rgb2=(0.62, 0.70, 0.80), width=256, height=256)
    element(asset, "texture", name=FLOOR, type="2d", builtin="checker", rgb1=(0.78, 0.80, 0.82), rgb2=(0.66, 0.68, 0.71), width=256, height=256)
    # one square of the checker is 10 mm
    element(asset, "material", name=FLOOR, texture=FLOOR, texrepeat=(1 / 20, 1 / 20), texuniform=True, reflectance=0.05)


def _surroundings(world: ET.Element) -> None:
    length = value("robot.body_length")
    element(world, "light", name="sun", mode="trackcom", pos=(-1.5 * length, 1.5 * length, 5 * length), dir=(0.3, -0.3, -1), cutoff=40, exponent=1,
            diffuse=(0.55, 0.55, 0.55), specular=(0.1, 0.1, 0.1))
    element(world, "geom", name=FLOOR, type="plane", pos=(0, 0, -FOOT_RADIUS), size=(0, 0, 0.2 * length), material=FLOOR, contype=0, conaffinity=0)
    right, up = (1, 0, 0), (0, 0, 1)
    element(world, "camera", name="overview", pos=(1.1 * length, 1.4 * length, 0.9 * length), mode="targetbody", target=BASE_FRAME)
    element(world, "camera", name="track", pos=(0.8 * length, -1.1 * length, 0.8 * length), mode="trackcom", xyaxes=(0.81, 0.59, 0, -0.22, 0.30, 0.93))
    element(world, "camera", name="side", pos=(0, -2 * length, 0.3 * length), mode="trackcom", xyaxes=(*right, *up))
    element(world, "camera", name="top", pos=(0, 0, 2.2 * length), mode="trackcom", xyaxes=(*right, 0, 1, 0))
