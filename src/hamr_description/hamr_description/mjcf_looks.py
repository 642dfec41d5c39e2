"""How the MuJoCo models look: colours, light, cameras, checker floor, the chassis and links as simple shapes (mm)."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np

from .names import BASE_FRAME
from .numbers import value
from .posture import stand_height
from .xml_tree import element

COLOURS = {
    "hull": (0.35, 0.40, 0.48, 0.25),
    "frame": (0.15, 0.16, 0.18, 1.0),
    "board": (0.10, 0.38, 0.25, 1.0),
    "swing": (0.91, 0.55, 0.13, 1.0),
    "lift": (0.18, 0.52, 0.80, 1.0),
    "leg": (0.86, 0.87, 0.89, 1.0),
    "foot": (0.80, 0.12, 0.15, 1.0),
}
FLOOR = "floor"
CHECKER = 10.0  # side of a square, mm
SEEN = {"mass": 0, "contype": 0, "conaffinity": 0, "group": 1}  # a shape without mass and contact


def add_looks(root: ET.Element) -> None:
    """Viewer settings and materials; lengths fit a robot of body length."""
    element(
        root, "statistic", extent=1.5 * value("robot.body_length"), center=(0, 0, stand_height()), meansize=0.1 * value("robot.body_length")
    )
    visual = element(root, "visual")
    element(visual, "global", azimuth=130, elevation=-20, offwidth=1920, offheight=1080)
    element(visual, "map", znear=0.01, zfar=50, shadowscale=0.9, force=200, torque=20)
    element(visual, "headlight", ambient=(0.3, 0.3, 0.3), diffuse=(0.3, 0.3, 0.3), specular=(0.1, 0.1, 0.1))
    element(visual, "quality", shadowsize=4096)
    element(visual, "scale", contactwidth=0.1, contactheight=0.02, forcewidth=0.05)
    asset = element(root, "asset")
    size = {"width": 256, "height": 256}
    element(asset, "texture", name="sky", type="skybox", builtin="gradient", rgb1=(0.92, 0.95, 0.98), rgb2=(0.62, 0.70, 0.80), **size)
    element(asset, "texture", name=FLOOR, type="2d", builtin="checker", rgb1=(0.78, 0.80, 0.82), rgb2=(0.66, 0.68, 0.71), **size)
    repeat = 1 / (2 * CHECKER)
    element(asset, "material", name=FLOOR, texture=FLOOR, texrepeat=(repeat, repeat), texuniform=True, reflectance=0.05)


def add_stage(world: ET.Element) -> None:
    """Light and cameras: `overview` turns with the robot's position, `track`, `side` and `top` follow it."""
    unit = value("robot.body_length")

    def place(*lengths: float) -> np.ndarray:
        return np.multiply(lengths, unit)

    light = {"cutoff": 40, "exponent": 1, "diffuse": (0.55, 0.55, 0.55), "specular": (0.1, 0.1, 0.1)}
    element(world, "light", name="sun", mode="trackcom", pos=place(-1.5, 1.5, 5), dir=(0.3, -0.3, -1), **light)
    element(world, "camera", name="overview", pos=place(1.1, 1.4, 0.9), mode="targetbody", target=BASE_FRAME)
    element(world, "camera", name="track", pos=place(0.95, -1.3, 0.85), mode="trackcom", xyaxes=(0.81, 0.59, 0, -0.20, 0.27, 0.94))
    element(world, "camera", name="side", pos=place(0, -2, 0.3), mode="trackcom", xyaxes=(1, 0, 0, 0, 0, 1))
    element(world, "camera", name="top", pos=place(0, 0, 2.2), mode="trackcom", xyaxes=(1, 0, 0, 0, 1, 0))


def add_chassis_shape(base: ET.Element) -> None:
    """A glass box with its edges, a circuit board below the lid and a red mark in front."""
    length, width, height = value("robot.chassis_size")
    low, high = value("robot.chassis_z_range")
    half, middle = np.divide((length, width, high - low), 2), np.array((0, 0, (low + high) / 2))
    board = 0.05 * height
    add_box(base, middle, half, colour="hull")
    add_box(base, (0, 0, high - 2 * board), (0.46 * length, 0.4 * width, board / 2), colour="board")
    add_box(base, (length / 2, 0, 0.7 * high), (0.2, 0.2 * width, 0.1 * height), colour="foot")
    for axis in range(3):
        others = [i for i in range(3) if i != axis]
        for signs in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            start = half.copy()
            start[others] *= signs
            end = start.copy()
            end[axis] *= -1
            add_capsule(base, middle + start, middle + end, radius=0.25, colour="frame")


def add_box(body: ET.Element, centre, half, *, colour: str) -> None:
    """A box by its centre and half sides, mm."""
    element(body, "geom", type="box", pos=centre, size=half, rgba=COLOURS[colour], **SEEN)


def add_capsule(body: ET.Element, start, end, *, radius: float, colour: str) -> None:
    """A bar between two points, mm; nothing where they coincide."""
    if np.linalg.norm(np.subtract(end, start)) > 0:
        element(body, "geom", type="capsule", fromto=(*start, *end), size=radius, rgba=COLOURS[colour], **SEEN)
