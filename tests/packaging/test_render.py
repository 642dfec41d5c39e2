"""The painter against a pinhole camera worked out by hand, and videos of bags with known motion."""

from __future__ import annotations

from pathlib import Path

import imageio.v3 as iio
import mujoco
import numpy as np
import pytest

from hamr_bags.frames import odometry_layout, state_layout
from hamr_bags.layout import Frame
from hamr_bags.writer import BagWriter
from hamr_bringup.motion import read_motion
from hamr_bringup.painter import Painter
from hamr_bringup.render import FRAMES_PER_SECOND, HEIGHT, WIDTH, render
from hamr_description.errors import BagError
from hamr_description.names import JOINTS, Topic
from hamr_description.rates import TARGET_NS

NO_TRAIL = np.zeros((0, 2))
FOVY = 40.0
BALL = np.array((3.0, 0.5, 2.0))
SCENE = f"""
<mujoco>
  <visual><map znear="0.001"/></visual>
  <worldbody>
    <camera name="eye" pos="0 -20 2" xyaxes="1 0 0 0 0 1" fovy="{FOVY}"/>
    <geom type="sphere" size="0.5" pos="{BALL[0]} {BALL[1]} {BALL[2]}" rgba="1 0 0 1"/>
    {{wall}}
    <body><freejoint/><geom type="sphere" size="0.01" pos="0 0 -50" mass="1"/></body>
  </worldbody>
</mujoco>"""


def red(picture: np.ndarray) -> np.ndarray:
    """Rows and columns (n, 2) of the red pixels."""
    channels = picture.astype(int)
    return np.argwhere((channels[..., 0] > 30) & (channels[..., 0] > 2 * channels[..., 1]) & (channels[..., 0] > channels[..., 2]))


def picture(wall: str = "") -> np.ndarray:
    model = mujoco.MjModel.from_xml_string(SCENE.format(wall=wall))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return Painter(model, height=400, width=600, camera="eye").frame(data, NO_TRAIL)


def test_a_ball_appears_where_a_pinhole_camera_sees_it():
    focal = 200 / np.tan(np.radians(FOVY / 2))
    depth = BALL[1] + 20
    pixels = red(picture())
    assert np.allclose(pixels.mean(0), (200 - focal * (BALL[2] - 2) / depth, 300 + focal * BALL[0] / depth), atol=1.0)
    assert np.ptp(pixels[:, 1]) == pytest.approx(2 * 0.5 * focal / depth, abs=2.0)


def test_what_is_near_hides_what_is_far():
    wall = '<geom type="box" size="5 0.1 5" pos="3 {} 2" rgba="0 0 1 1"/>'
    assert len(red(picture(wall.format(-5)))) == 0
    assert len(red(picture(wall.format(5)))) == pytest.approx(len(red(picture())), rel=0.1)


ANGLES = np.linspace(-0.3, 0.3, 8)


def write_bag(folder: Path, *, periods: int = 50, order: tuple[int, ...] = tuple(range(8)), odometry: bool = True) -> Path:
    """Hip angle j is ANGLES[j] * t / T; the base goes along x at 0.1 m/s and turns left at 1 rad/s."""
    joints, base = Frame(state_layout(tuple(JOINTS[i] for i in order))), Frame(odometry_layout())
    with BagWriter(folder) as bag:
        for k in range(periods):
            stamp, share = k * TARGET_NS, k / (periods - 1)
            seconds = stamp * 1e-9
            joints.stamp(stamp)
            joints.numbers["position"][...] = ANGLES[list(order)] * share
            bag.write(Topic.JOINT_STATES, bytes(joints), stamp)
            if odometry:
                base.stamp(stamp)
                base.numbers["position"][...] = (0.1 * seconds, 0.0, 0.013)
                base.numbers["orientation"][...] = (0.0, 0.0, np.sin(seconds / 2), np.cos(seconds / 2))
                bag.write(Topic.ODOM, bytes(base), stamp)
    return folder


def test_motion_is_read_by_joint_name_and_interpolated(tmp_path):
    motion = read_motion(write_bag(tmp_path / "bag", order=(3, 1, 4, 0, 5, 7, 2, 6)))
    end = motion.time[-1]
    times = np.array((0.0, 0.3 * end, end))
    assert np.allclose(motion.angles_at(times), np.outer((0, 0.3, 1), ANGLES))
    position, quaternion = motion.base_at(times)
    assert np.allclose(position, np.column_stack((100 * times, 0 * times, np.full(3, 13.0))))  # mm
    assert np.allclose(quaternion, np.column_stack((np.cos(times / 2), 0 * times, 0 * times, np.sin(times / 2))))


@pytest.mark.parametrize("odometry", [True, False])
def test_a_bag_becomes_a_video_of_the_right_length(tmp_path, odometry):
    bag = write_bag(tmp_path / "bag", odometry=odometry)
    result = render([bag], tmp_path / "new/video.mp4", slow=4.0)
    frames = iio.imread(result["video"])
    assert len(frames) == result["frames"] == int(49 * TARGET_NS * 1e-9 * 4 * FRAMES_PER_SECOND)
    assert frames.shape[1:] == (HEIGHT, WIDTH, 3)
    assert np.abs(frames[-1].astype(int) - frames[0]).max() > 100, "nothing moves"


def test_two_bags_stand_side_by_side_for_the_length_of_the_shorter(tmp_path):
    bags = [write_bag(tmp_path / "long"), write_bag(tmp_path / "short", periods=20)]
    result = render(bags, tmp_path / "video.mp4", slow=2.0)
    assert result["seconds"] == pytest.approx(19 * TARGET_NS * 1e-9)
    assert iio.immeta(result["video"])["size"][0] > WIDTH


def test_a_bag_without_angles_is_refused_in_one_sentence(tmp_path):
    base = Frame(odometry_layout())
    base.numbers["orientation"][...] = (0, 0, 0, 1)
    with BagWriter(tmp_path / "bag") as bag:
        base.stamp(0)
        bag.write(Topic.ODOM, bytes(base), 0)
    with pytest.raises(BagError, match="holds no /servo"):
        render([tmp_path / "bag"], tmp_path / "video.mp4")
    assert not (tmp_path / "video.mp4").exists()
