"""The workspace builds with the real colcon, and what it builds runs without the source tree."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = sorted(manifest.parent.name for manifest in (ROOT / "src").glob("*/package.xml"))
COLCON = shutil.which("colcon", path=os.pathsep.join((str(Path(sys.executable).parent), os.environ["PATH"])))

pytestmark = pytest.mark.skipif(COLCON is None, reason="colcon is not installed; the extra `ros` brings it")


@pytest.fixture(scope="module")
def workspace(tmp_path_factory) -> Path:
    """A copy of src and ros_ws, built."""
    copy = tmp_path_factory.mktemp("checkout")
    leave = shutil.ignore_patterns("__pycache__", "build", "install", "log", "*.egg-info")
    shutil.copytree(ROOT / "src", copy / "src", ignore=leave)
    shutil.copytree(ROOT / "ros_ws", copy / "ros_ws", symlinks=True, ignore=leave)
    built = colcon(copy / "ros_ws", "build")
    assert f"Summary: {len(PACKAGES)} packages finished" in built.stdout + built.stderr, built.stderr
    return copy / "ros_ws"


def colcon(folder: Path, *words: str) -> subprocess.CompletedProcess:
    clean = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    return subprocess.run([COLCON, *words], cwd=folder, env=clean, capture_output=True, text=True, check=True)


def test_every_package_is_an_ament_python_package(workspace):
    """An e-mail address that catkin_pkg refuses would silently make it a plain Python package, which `ros2 run` cannot find."""
    listed = dict(line.split("\t")[::2] for line in colcon(workspace, "list").stdout.strip().split("\n"))
    assert listed == dict.fromkeys(PACKAGES, "(ros.ament_python)")


def test_installation_is_what_ros2_run_and_ros2_pkg_look_for(workspace):
    for package in PACKAGES:
        prefix = workspace / "install" / package
        assert (prefix / "share/ament_index/resource_index/packages" / package).exists()
        assert (prefix / "share" / package / "package.xml").exists()
        nodes = {file.stem.removesuffix("_node") for file in (ROOT / "src" / package / package).glob("*_node.py")}
        assert {file.name for file in (prefix / "lib" / package).glob("*")} == nodes
        for folder in ("launch", "config"):
            files = {file.name for file in (ROOT / "src" / package / folder).glob("*")} - {"__pycache__"}
            assert {file.name for file in (prefix / "share" / package / folder).glob("*")} == files


def test_built_packages_find_their_data(workspace):
    code = "import hamr_description.numbers as n; print(n.__file__); print(n.value('robot.gravity'))"
    script = f"source install/setup.bash && exec {sys.executable} -c \"{code}\""
    clean = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    out = subprocess.run(["bash", "-c", script], cwd=workspace, env=clean, capture_output=True, text=True, check=True).stdout.split()
    assert Path(out[0]).is_relative_to(workspace / "install")
    assert float(out[1]) > 0
