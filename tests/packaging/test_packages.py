"""pip and colcon build the same packages: one version, one licence, the same files and executables; the pins agree."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
PACKAGES = sorted(manifest.parent for manifest in (ROOT / "src").glob("*/package.xml"))
each_package = pytest.mark.parametrize("package", PACKAGES, ids=lambda package: package.name)


def manifest(package: Path) -> ET.Element:
    return ET.parse(package / "package.xml").getroot()


def test_pip_installs_every_package_and_no_other():
    assert {ROOT / where for where in PROJECT["tool"]["setuptools"]["packages"]["find"]["where"]} == set(PACKAGES)


@each_package
def test_manifest_agrees_with_the_project(package):
    root = manifest(package)
    assert root.findtext("name") == package.name
    assert root.findtext("version") == PROJECT["project"]["version"]
    assert root.findtext("license") == PROJECT["project"]["license"]
    assert root.findtext("export/build_type") == "ament_python"


@each_package
def test_setup_is_the_same_file_everywhere(package):
    assert (package / "setup.py").read_bytes() == (PACKAGES[0] / "setup.py").read_bytes()
    assert (package / "resource" / package.name).is_file()
    assert (package / "setup.cfg").read_text() == (PACKAGES[0] / "setup.cfg").read_text().replace(PACKAGES[0].name, package.name)


@each_package
def test_workspace_links_to_the_package(package):
    link = ROOT / "ros_ws/src" / package.name
    assert link.is_symlink()
    assert not os.path.isabs(os.readlink(link))
    assert link.resolve() == package


def test_workspace_holds_nothing_else():
    assert {path.name for path in (ROOT / "ros_ws/src").iterdir()} == {package.name for package in PACKAGES}


@each_package
def test_every_node_is_an_executable_of_the_same_name(package, tmp_path):
    """What setup.py declares to ROS, and what `hamr run` finds, is one executable X for each file X_node.py."""
    subprocess.run([sys.executable, "setup.py", "-q", "egg_info", "-e", str(tmp_path)], cwd=package, check=True, capture_output=True)
    declared = next(tmp_path.glob("*.egg-info")) / "entry_points.txt"
    lines = set(declared.read_text().split("\n")[1:]) - {""} if declared.exists() else set()
    nodes = [file.stem for file in (package / package.name).glob("*_node.py")]
    assert lines == {f"{node.removesuffix('_node')} = {package.name}.{node}:main" for node in nodes}


def test_data_files_reach_both_installations():
    """Whatever a package needs besides Python files has an ending that both setups ship."""
    shipped = {pattern.rpartition(".")[2] for pattern in PROJECT["tool"]["setuptools"]["package-data"]["*"]}
    tracked = subprocess.run(["git", "ls-files", "src"], cwd=ROOT, check=True, capture_output=True, text=True).stdout.split()
    inside = [path for path in tracked if path.split("/")[1] == path.split("/")[2]]
    assert {Path(path).suffix[1:] for path in inside} <= shipped | {"py"}
    ending = r'f"\*\*/\*\.\{suffix\}" for suffix in \(([^)]*)\)'
    listed = re.search(ending, (PACKAGES[0] / "setup.py").read_text())
    assert set(re.findall(r'"(\w+)"', listed[1])) == shipped


def test_pins_are_exact_and_agree_with_the_constraints():
    constraints = dict(line.split("==") for line in (ROOT / "constraints.txt").read_text().split("\n") if line and line[0] != "#")
    extras = PROJECT["project"]["optional-dependencies"]
    for pin in [*PROJECT["project"]["dependencies"], *extras["ros"], *extras["test"]]:
        if pin != "hamr[ros]":
            name, _, version = pin.partition("==")
            assert constraints[re.sub(r"[-_.]+", "-", name).lower()] == version, pin
    assert PROJECT["build-system"]["requires"] == [f"setuptools=={constraints['setuptools']}"]
    assert not [name for name in constraints if re.search("nvidia|cuda|triton", name)]
