"""Imports point one way, and package.xml declares what is imported. The truth is the syntax tree of every file, not what happens to run."""

from __future__ import annotations

import ast
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

SOURCE = Path(__file__).parents[2] / "src"
#: From the lowest to the highest; a package may import those before it (docs/architecture.md).
LAYERS = (
    "hamr_description",
    "hamr_dynamics",
    "hamr_sim_full",
    "hamr_sim_residual",
    "hamr_bags",
    "hamr_controller",
    "hamr_policy",
    "hamr_gap",
    "hamr_bringup",
)
#: The same for the folders of hamr_gap; what stands above them all is the ways in.
INSIDE_GAP = ("data", "fitting", "naming", "judging", "experiments", "answers", "showing")
#: What nodes have in common lives there, so node files may import it from below; hamr_bags cannot declare so, as it is needed there itself.
SHARED_BY_NODES = "hamr_controller"
#: A second program beside hamr_gap's, its adversary.
ADVERSARY = "hidden_gap"
FILES = sorted(file for package in LAYERS for inside in (package, ADVERSARY) for file in (SOURCE / package / inside).rglob("*.py"))


def imports(file: Path, *, at_start: bool = False) -> Iterator[str]:
    """Modules that a file imports by absolute name; `at_start`: only what runs when the file is imported."""
    nodes = ast.parse(file.read_text()).body if at_start else [ast.parse(file.read_text())]
    while nodes:
        node = nodes.pop()
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield node.module
        elif not at_start or not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            nodes.extend(ast.iter_child_nodes(node))


def package_of(file: Path) -> str:
    return file.relative_to(SOURCE).parts[0]


def declared(package: str) -> set[str]:
    return {depend.text for depend in ET.parse(SOURCE / package / "package.xml").getroot().iter("exec_depend")}


def test_every_package_has_its_layer():
    assert {manifest.parent.name for manifest in SOURCE.glob("*/package.xml")} == set(LAYERS)
    assert len(FILES) > len(LAYERS)


@pytest.mark.parametrize("package", LAYERS)
def test_a_package_imports_only_lower_ones_and_declares_them(package):
    lower = LAYERS[: LAYERS.index(package)]
    for file in (file for file in FILES if package_of(file) == package):
        allowed = {*lower, package, *([SHARED_BY_NODES] if file.stem.endswith("_node") else [])}
        imported = {name.split(".")[0] for name in imports(file) if name.startswith("hamr_")}
        assert imported <= allowed, f"{file.name} imports {imported - allowed}"
        undeclared = imported - {package} - declared(package) - ({SHARED_BY_NODES} if package == "hamr_bags" else set())
        assert not undeclared, f"{file.name}: package.xml lacks {undeclared}"


def test_the_adversary_of_the_gap_workflow_shares_no_dynamics_with_it():
    files = sorted((SOURCE / "hamr_gap" / ADVERSARY).rglob("*.py"))
    assert files
    for file in files:
        assert {name.split(".")[0] for name in imports(file)} & set(LAYERS) <= {"hamr_description", "hamr_bags"}, file.name
    workflow = SOURCE / "hamr_gap" / "hamr_gap"
    solver = [file for file in workflow.rglob("*.py") if file.parent != workflow / "bench"]  # the bench draws cases and scores answers
    assert solver
    for file in solver:
        assert not any(name.split(".")[0] == ADVERSARY for name in imports(file)), f"{file.name} must not know what hides"


@pytest.mark.parametrize("folder", INSIDE_GAP)
def test_a_folder_of_the_gap_workflow_imports_only_those_before_it(folder):
    root = SOURCE / "hamr_gap" / "hamr_gap"
    files = sorted((root / folder).rglob("*.py"))
    assert files
    for file in files:
        above = {relative.split(".")[0] for relative in upward(file)}
        assert above <= set(INSIDE_GAP[: INSIDE_GAP.index(folder)]), f"{folder}/{file.name} imports {above}"


def upward(file: Path) -> Iterator[str]:
    """Modules that a file imports from beside its folder, as named from there."""
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.ImportFrom) and node.level == 2:
            yield from [node.module] if node.module else [alias.name for alias in node.names]


def test_declared_dependencies_have_no_cycle():
    graph = {package: declared(package) & set(LAYERS) for package in LAYERS}
    assert len(list(TopologicalSorter(graph).static_order())) == len(LAYERS)


@pytest.mark.parametrize("file", FILES, ids=lambda file: f"{file.relative_to(SOURCE / package_of(file))}")
def test_ros_stays_at_the_edge(file):
    shared = SOURCE / SHARED_BY_NODES / SHARED_BY_NODES / "ros"
    if not (file.stem.endswith("_node") or package_of(file) == "hamr_bringup" or file.is_relative_to(shared)):
        assert not any(name.split(".")[0] == "rclpy" for name in imports(file)), "rclpy belongs into nodes, hamr_bringup and controller/ros"


def test_dynamics_import_no_torch():
    for file in (file for file in FILES if package_of(file) in ("hamr_description", "hamr_dynamics", "hamr_controller")):
        assert not any(name.split(".")[0] == "torch" for name in imports(file, at_start=True)), file.name
