"""The feet's contact in MuJoCo: a spring and damper with Coulomb friction, not the hopping of its hard convex contact."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from hamr_sim_full.mujoco_contact import set_contact

MASS, GRAVITY, FRICTION, STEP = 0.37, 9.81e-3, 0.29, 0.05  # a quarter of the robot, on the smoothest surface
BLOCK = f"""
<mujoco>
  <compiler boundmass="0" boundinertia="0"/>
  <option timestep="{STEP}" gravity="0 0 -{GRAVITY}" cone="elliptic" solver="Newton" tolerance="1e-12" jacobian="dense"/>
  <worldbody>
    <geom name="floor" type="plane" size="0 0 1" pos="0 0 -0.001" contype="0" conaffinity="0"/>
    <body>
      <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/><joint type="slide" axis="0 0 1"/>
      <geom name="block" size="0.001" mass="{MASS}" contype="0" conaffinity="0"/>
    </body>
  </worldbody>
  <contact>
    <pair geom1="floor" geom2="block" condim="3" friction="{FRICTION} {FRICTION} 0 0 0" solref="0.1 1" solimp="0.99 0.99 0.001 0.5 2"/>
  </contact>
</mujoco>"""


def slide(model: mujoco.MjModel, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """Speeds and heights over 20 ms of a block on the ground that starts at `speed`, mm/ms and mm."""
    data = mujoco.MjData(model)
    data.qvel[0] = speed
    found = []
    for _ in range(400):
        mujoco.mj_step(model, data)
        found.append((data.qvel[0], data.qpos[2]))
    return tuple(np.array(found).T)


def test_a_sliding_block_is_slowed_by_coulomb_friction_and_stays_down():
    model = mujoco.MjModel.from_xml_string(BLOCK)
    hard = slide(model, 0.3)[1].max()
    set_contact(model)
    speed, height = slide(model, 0.3)
    assert (0.3 - speed[-1]) / (400 * STEP) == pytest.approx(FRICTION * GRAVITY, rel=0.02)
    assert height.max() < 1e-3
    assert hard > 0.1, "mm: what the setting is there to avoid"


def test_a_block_at_rest_sinks_by_its_weight_over_the_stiffness():
    model = mujoco.MjModel.from_xml_string(BLOCK)
    set_contact(model)
    speed, height = slide(model, 0.0)
    assert height[-1] == pytest.approx(-MASS * GRAVITY / 2.0, rel=0.01)
    assert abs(speed[-1]) < 1e-9


def test_friction_holds_up_to_its_limit_and_no_further():
    model = mujoco.MjModel.from_xml_string(BLOCK)
    set_contact(model)
    for pull, slips in ((0.95, False), (1.05, True)):
        data = mujoco.MjData(model)
        for _ in range(1000):
            data.qfrc_applied[0] = pull * FRICTION * MASS * GRAVITY * min(1.0, data.time / 20.0)
            mujoco.mj_step(model, data)
        assert (data.qvel[0] > 1e-3) == slips


def test_blows_are_absorbed():
    """A block falling at 0.3 m/s stops within a tenth of a millimetre or three and hardly rebounds."""
    model = mujoco.MjModel.from_xml_string(BLOCK)
    set_contact(model)
    data = mujoco.MjData(model)
    data.qvel[2] = -0.3
    heights = []
    for _ in range(400):
        mujoco.mj_step(model, data)
        heights.append(data.qpos[2])
    assert -0.3 < min(heights) < -0.05
    assert max(heights) < 1.0
