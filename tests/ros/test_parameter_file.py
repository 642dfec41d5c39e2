"""config/hamr.yaml shows the parameters with their true defaults, and a graph gives a parameter file to those that it names."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import pytest
import yaml

import hamr_bringup
from hamr_bags import excitation_node
from hamr_bringup.graph import Run, graph
from hamr_controller import leg_controller_node
from hamr_controller.ros.simulator_parameters import SimulatorParameters
from hamr_description.errors import ConfigError
from hamr_policy import policy_node

FILE = Path(hamr_bringup.__file__).parents[1] / "config" / "hamr.yaml"
PHYSICAL = {"friction", "kp", "kd"}  # numbers.yaml alone has their values
NODES = {
    "simulator": SimulatorParameters,
    "leg_controller": leg_controller_node.Parameters,
    "excitation": excitation_node.Parameters,
    "policy": policy_node.Parameters,
}


@pytest.mark.parametrize("name", NODES)
def test_the_file_shows_the_defaults_of_each_node(name):
    shown = yaml.safe_load(FILE.read_text())[name]["ros__parameters"]
    defaults = NODES[name]()
    assert shown == {entry.name: getattr(defaults, entry.name) for entry in fields(defaults) if entry.name not in PHYSICAL}
    for entry in fields(defaults):
        assert entry.metadata["what"], entry.name


def test_a_graph_gives_the_file_to_the_nodes_that_it_names(tmp_path):
    mine = tmp_path / "mine.yaml"
    mine.write_text("leg_controller:\n  ros__parameters:\n    kp: [1.0, 1.0]\n")
    files = {node.name: node.file for node in graph(Run(backend="simple", parameters=str(mine)))}
    assert files == {"simulator": "", "leg_controller": str(mine)}
    specs = graph(Run(backend="simple", parameters=str(mine), bag="out"))
    assert next(node for node in specs if node.name == "leg_controller").arguments()[:3] == ["--ros-args", "--params-file", str(mine)]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (None, "cannot be read"),
        ("a: [", "cannot be read"),
        ("", "names no node"),
        ("leg_controler: {}", "names 'leg_controler', which is no node"),
    ],
)
def test_a_file_that_speaks_to_nobody_is_refused(tmp_path, text, said):
    file = tmp_path / "mine.yaml"
    if text is not None:
        file.write_text(text)
    with pytest.raises(ConfigError, match=said):
        graph(Run(backend="simple", parameters=str(file)))
