"""The MuJoCo models as text and as compiled models: loading, names, keyframes, cameras, contact, nothing lost in writing."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hamr_description import mirror, mjcf
from hamr_description.errors import ConfigError
from hamr_description.names import ACTUATORS, BASE_FRAME, JOINTS, LEGS
from hamr_description.numbers import value
from hamr_description.simple_constants import simple_constants
from hamr_description.xml_tree import document, element

BUILDERS = {
    "full": lambda **options: mjcf.full(c0=1.4413e-3, c1=1.712e-3, **options),
    "simple": lambda **options: mjcf.simple(simple_constants(), **options),
    "simple_published": mjcf.simple_published,
}
ENVIRONMENTS = ("ground", "suspended")


@pytest.fixture(params=[(name, environment) for name in BUILDERS for environment in ENVIRONMENTS], ids="-".join)
def built(request):
    name, environment = request.param
    text = BUILDERS[name](environment=environment)
    model = mujoco.MjModel.from_xml_string(text)
    return name, environment, text, model, mujoco.MjData(model)


def test_freedom_names_and_step(built):
    name, environment, _, model, _ = built
    joints = {"full": 32, "simple": 8, "simple_published": 8}[name]
    assert model.nv == joints + (6 if environment == "ground" else 0)
    assert [model.actuator(i).name for i in range(model.nu)] == list(ACTUATORS)
    assert model.neq == (12 if name == "full" else 0)
    assert {model.site(f"{leg}_foot").name for leg in LEGS} == {"fl_foot", "rl_foot", "fr_foot", "rr_foot"}
    assert {model.camera(i).name for i in range(model.ncam)} >= {"track", "side", "top"}
    assert model.opt.timestep == 0.05
    assert model.opt.gravity.tolist() == [0, 0, -9.81e-3]
    if name == "simple":
        assert {model.joint(i).name for i in range(model.njnt)} - {BASE_FRAME} == set(JOINTS)


def test_keyframes(built):
    """Standing feet just touch, hanging feet are as far above the ground as they reach down."""
    _, environment, _, model, data = built
    for key, height in (("stand", 12.54 if environment == "ground" else 25.08), ("suspended", 25.08)):
        mujoco.mj_resetDataKeyframe(model, data, model.key(key).id)
        mujoco.mj_forward(model, data)
        assert data.body(BASE_FRAME).xpos == pytest.approx([0, 0, height], abs=1e-9)
        assert data.ctrl == pytest.approx(np.full(8, 112.5))
        assert np.abs(data.qfrc_actuator).max() < 1e-15, "neutral drives do not pull"
        assert not data.qvel.any()
        for leg in LEGS:
            assert data.site(f"{leg}_foot").xpos[2] == pytest.approx(height - 12.54, abs=1e-4)
        floor = model.geom("floor").pos[2]
        gaps = [data.geom(f"{leg}_foot").xpos[2] - model.geom(f"{leg}_foot").size[0] - floor for leg in LEGS]
        assert gaps == pytest.approx(np.full(4, height - 12.54), abs=1e-4)


@pytest.mark.parametrize("name", BUILDERS)
def test_feet_alone_touch_the_floor_by_the_given_friction(name):
    model = mujoco.MjModel.from_xml_string(BUILDERS[name](friction=0.29))
    assert sorted(model.pair(i).name for i in range(model.npair)) == sorted(f"{leg}_foot" for leg in LEGS)
    assert model.pair_friction[:, :2] == pytest.approx(0.29)
    assert not model.pair_friction[:, 2:].any()
    assert (model.pair_dim == 3).all()
    assert not model.geom_contype.any() and not model.geom_conaffinity.any()
    default = mujoco.MjModel.from_xml_string(BUILDERS[name]())
    assert default.pair_friction[:, :2] == pytest.approx(value("contact.friction"))
    assert mujoco.MjModel.from_xml_string(BUILDERS[name](environment="suspended")).npair == 0


@pytest.mark.parametrize("name", BUILDERS)
def test_gravity_is_a_choice(name):
    assert not mujoco.MjModel.from_xml_string(BUILDERS[name](gravity=0.0)).opt.gravity.any()


@pytest.mark.parametrize("name", BUILDERS)
def test_unknown_environment_is_named(name):
    with pytest.raises(ConfigError, match="'water' is unknown; choose one of ground, suspended"):
        BUILDERS[name](environment="water")


def test_shapes_have_no_mass(built):
    """Mass comes from the numbers alone: every body's equals its inertial element's."""
    name, _, text, model, _ = built
    inertials = {body.get("name"): float(body.find("inertial").get("mass")) for body in ET.fromstring(text).iter("body")}
    assert {body: model.body(body).mass[0] for body in inertials} == inertials
    total = {"full": 1.47499, "simple": 1.47499, "simple_published": 1.47317}[name]
    assert sum(inertials.values()) == pytest.approx(total, abs=1e-5)


def test_cameras_see_the_robot(built):
    """The robot lies inside every camera's depth range and field of view."""
    _, _, _, model, data = built
    mujoco.mj_resetDataKeyframe(model, data, model.key("stand").id)
    mujoco.mj_forward(model, data)
    near, far = (float(x) * model.stat.extent for x in (model.vis.map.znear, model.vis.map.zfar))
    for i in range(model.ncam):
        for site in [BASE_FRAME, *(f"{leg}_foot" for leg in LEGS)]:
            x, y, z = data.cam_xmat[i].reshape(3, 3).T @ (data.site(site).xpos - data.cam_xpos[i])
            assert near < -z < far, model.camera(i).name
            assert max(abs(x), abs(y)) < -z * np.tan(np.radians(model.cam_fovy[i]) / 2), (model.camera(i).name, site)


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=1, max_size=6))
def test_numbers_are_written_without_loss(values):
    text = document(element(None, "x", numbers=np.array(values)))
    assert [float(v) for v in ET.fromstring(text).get("numbers").split()] == values


@given(st.sampled_from(LEGS), st.lists(st.floats(-10, 10), min_size=9, max_size=9))
def test_mirrored_inertia_is_that_of_mirrored_points(leg, numbers):
    """Tensor of three unit masses: mirror the points, or mirror their tensor."""

    def tensor(points):
        total = sum(np.dot(p, p) * np.eye(3) - np.outer(p, p) for p in points)
        return [*np.diag(total), total[0, 1], total[0, 2], total[1, 2]]

    points = np.reshape(numbers, (3, 3))
    assert mirror.inertia(leg, tensor(points)) == pytest.approx(tensor([mirror.point(leg, p) for p in points]), abs=1e-12)
    assert mirror.point(leg, mirror.point(leg, points[0])) == pytest.approx(points[0])
