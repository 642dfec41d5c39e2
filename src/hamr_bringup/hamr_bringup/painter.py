"""Frames of a MuJoCo scene without OpenGL: flat-shaded faces from far to near, on a chequered floor with shadows.

It draws the same abstract scene (geoms, camera, colours) that MuJoCo's own renderer draws, for machines without EGL or OSMesa.
"""

from __future__ import annotations

from functools import cache

import mujoco
import numpy as np
from PIL import Image, ImageDraw
from scipy.spatial import ConvexHull

SUN = np.array((-0.35, 0.45, 0.82)) / np.linalg.norm((-0.35, 0.45, 0.82))  # towards the light
SKY, TILES, SHADOW, TRAIL = (236, 241, 246), ((226, 229, 232), (208, 212, 217)), (120, 126, 136), (200, 30, 40)
TILE, TILES_AROUND = 10.0, 14  # mm; tiles from the point looked at to the edge of the floor
OVERSAMPLING = 2
SIDES = 10  # of a round geom


class Painter:
    """Draws frames of `height` x `width` pixels.

    Args:
        camera: name of a camera of the model.
    """

    def __init__(self, model: mujoco.MjModel, *, height: int, width: int, camera: str) -> None:
        self._model, self._size = model, (height * OVERSAMPLING, width * OVERSAMPLING)
        self._scene = mujoco.MjvScene(model, maxgeom=1000)
        self._option = mujoco.MjvOption()
        self._camera = mujoco.MjvCamera()
        self._camera.type, self._camera.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, model.camera(camera).id

    def frame(self, data: mujoco.MjData, trail: np.ndarray, caption: str = "") -> np.ndarray:
        """The picture (height, width, 3) uint8 of a state on which mj_forward ran, with the way so far, `trail` (n, 2) mm, on the floor."""
        mujoco.mjv_updateScene(self._model, data, self._option, None, self._camera, mujoco.mjtCatBit.mjCAT_ALL, self._scene)
        height, width = self._size
        view = _View(self._scene.camera[0], height, width)
        image = Image.new("RGB", (width, height), SKY)
        draw = ImageDraw.Draw(image, "RGBA")
        geoms = self._scene.geoms[: self._scene.ngeom]
        solids = [_solid(geom) for geom in geoms if geom.type in SHAPES]
        for floor in (geom for geom in geoms if geom.type == mujoco.mjtGeom.mjGEOM_PLANE):
            _paint_floor(draw, view, data.qpos[:2], float(floor.pos[2]), solids)
            _paint_trail(draw, view, np.column_stack((trail, np.full(len(trail), floor.pos[2]))))
        for outline, colour in _faces(view, solids):
            draw.polygon(outline, fill=colour)
        draw.text((height // 30, height // 30), caption, fill=(40, 44, 52), font_size=height // 24)
        return np.asarray(image.reduce(OVERSAMPLING))


class _View:
    """Perspective of a MuJoCo camera: points (n, 3) -> pixels (n, 2) and depth (n,)."""

    def __init__(self, camera: mujoco.MjvGLCamera, height: int, width: int) -> None:
        self.eye, self.forward, self.up = np.array(camera.pos, float), np.array(camera.forward, float), np.array(camera.up, float)
        self.right = np.cross(self.forward, self.up)
        self.near, self._middle = camera.frustum_near, (width / 2, height / 2)
        self._focal = height / 2 * camera.frustum_near / camera.frustum_top

    def __call__(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        rays = points - self.eye
        depth = rays @ self.forward
        scale = self._focal / np.maximum(depth, self.near)
        return np.stack((self._middle[0] + scale * (rays @ self.right), self._middle[1] - scale * (rays @ self.up)), -1), depth


def _paint_floor(draw: ImageDraw.ImageDraw, view: _View, middle: np.ndarray, height: float, solids: list) -> None:
    """Tiles around `middle` (2,), then the shadow of every solid that is not see-through."""
    first = np.floor(middle / TILE).astype(int) - TILES_AROUND
    corners = np.array(((0, 0), (1, 0), (1, 1), (0, 1)))
    tiles = np.stack(np.meshgrid(*(start + np.arange(2 * TILES_AROUND) for start in first), indexing="ij"), -1).reshape(-1, 2)
    points = np.concatenate(((tiles[:, None] + corners) * TILE, np.full((len(tiles), 4, 1), height)), -1)
    pixels, depth = view(points)
    seen = depth.min(1) > view.near
    for outline, colour in zip(_outlines(pixels[seen]), tiles[seen].sum(1) % 2, strict=True):
        draw.polygon(outline, fill=TILES[colour])
    for vertices, _, rgba in solids:
        if rgba[3] == 1:
            ground = vertices - SUN * ((vertices[:, 2:] - height) / SUN[2])
            outline, deep = view(ground[ConvexHull(ground[:, :2]).vertices])
            if deep.min() > view.near:
                draw.polygon(outline.ravel().tolist(), fill=SHADOW)


def _paint_trail(draw: ImageDraw.ImageDraw, view: _View, points: np.ndarray) -> None:
    pixels, depth = view(points)
    seen = depth > view.near
    if seen.sum() > 1:
        draw.line(pixels[seen].ravel().tolist(), fill=TRAIL, width=2 * OVERSAMPLING)


def _faces(view: _View, solids: list) -> list[tuple[list, tuple]]:
    """Outline and colour of every face turned to the eye, far ones first."""
    painted = []
    for vertices, faces, rgba in solids:
        pixels, depth = view(vertices)
        if depth.min() <= view.near:
            continue
        a, b, c = (vertices[faces[:, i]] for i in (0, 1, 2))
        normals = np.cross(b - a, c - a)
        light = 0.62 + 0.38 * (normals @ SUN) / np.maximum(np.linalg.norm(normals, axis=1), 1e-12)
        colours = np.minimum(255 * light[:, None] * rgba[:3], 255).astype(int)
        front = np.einsum("ij,ij->i", normals, view.eye - a) > 0
        fills = np.column_stack((colours[front], np.full(front.sum(), int(255 * rgba[3]))))
        painted += zip(depth[faces[front]].mean(1).tolist(), _outlines(pixels[faces[front]]), map(tuple, fills.tolist()), strict=True)
    painted.sort(key=lambda entry: -entry[0])
    return [entry[1:] for entry in painted]


def _outlines(corners: np.ndarray) -> list[list[float]]:
    """Corners (n, m, 2) as PIL takes them: x, y, x, y, ... of each polygon."""
    return corners.reshape(len(corners), -1).tolist()


def _solid(geom: mujoco.MjvGeom) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices (n, 3) in the world, faces (m, 4) as indices counter-clockwise from outside, and rgba of a geom."""
    unit, faces = SHAPES[geom.type]()
    local = unit * geom.size
    if geom.type == mujoco.mjtGeom.mjGEOM_CAPSULE:  # size: radius, radius, half length of the cylinder
        local = unit * geom.size[0]
        local[:, 2] += np.sign(unit[:, 2]) * geom.size[2]
    return local @ np.asarray(geom.mat).reshape(3, 3).T + geom.pos, faces, np.array(geom.rgba)


@cache
def _box() -> tuple[np.ndarray, np.ndarray]:
    vertices = np.array([(x, y, z) for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
    return vertices, np.array(((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)))


@cache
def _ball() -> tuple[np.ndarray, np.ndarray]:
    """Rings of latitude, none on the equator, so that a capsule is a ball whose halves are moved apart."""
    latitudes = np.radians((-90, -55, -1, 1, 55, 90))
    turns = np.linspace(0, 2 * np.pi, SIDES, endpoint=False)
    rings = np.stack([(np.cos(up) * np.cos(turn), np.cos(up) * np.sin(turn), np.sin(up)) for up in latitudes for turn in turns])
    faces = [(r * SIDES + s, r * SIDES + n, (r + 1) * SIDES + n, (r + 1) * SIDES + s)
             for r in range(len(latitudes) - 1) for s in range(SIDES) for n in [(s + 1) % SIDES]]
    return rings, np.array(faces)


SHAPES = {
    mujoco.mjtGeom.mjGEOM_BOX: _box,
    mujoco.mjtGeom.mjGEOM_SPHERE: _ball,
    mujoco.mjtGeom.mjGEOM_CAPSULE: _ball,
    mujoco.mjtGeom.mjGEOM_ELLIPSOID: _ball,
}
