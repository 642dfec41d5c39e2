"""`up`: the real graph with a real robot and a policy file, as processes under the supervisor."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from harness import contents
from onnx import TensorProto, helper, numpy_helper

from hamr_bringup.direct import direct
from hamr_bringup.graph import Run, run_of_words
from hamr_bringup.supervisor import NodeFailed, up
from hamr_description.errors import ConfigError
from hamr_description.names import Topic
from hamr_policy.policy_file import INPUT, KEY, OUTPUT, interface


def policy_file(path: Path) -> str:
    """A policy with random weights: 0.2 rad tanh(W observation)."""
    about = {**interface("walk", "place"), "view": "place"}
    size = len(about["observation"])
    weights = np.random.default_rng(0).normal(0, 0.5, (size, 8)).astype(np.float32)
    nodes = [
        helper.make_node("MatMul", [INPUT, "weights"], ["x"]),
        helper.make_node("Tanh", ["x"], ["y"]),
        helper.make_node("Mul", ["y", "limit"], [OUTPUT]),
    ]
    constants = [numpy_helper.from_array(weights, "weights"), numpy_helper.from_array(np.float32(0.2), "limit")]
    ends = [[helper.make_tensor_value_info(name, TensorProto.FLOAT, ["robots", n])] for name, n in ((INPUT, size), (OUTPUT, 8))]
    model = helper.make_model(
        helper.make_graph(nodes, "policy", *ends, constants), opset_imports=[helper.make_opsetid("", 21)], ir_version=10
    )
    helper.set_model_props(model, {KEY: json.dumps(about)})
    path.write_bytes(model.SerializeToString())
    return str(path)


def test_processes_walk_as_the_run_without_ros_does(graph, tmp_path):
    run = dict(backend="simple", policy=policy_file(tmp_path / "walk.onnx"), command="backward", seconds=0.2, real_time_factor=0.0)
    report = up(Run(**run, bag=str(tmp_path / "up")))
    assert report["nodes"] == {"simulator": 0, "leg_controller": 0, "policy": 0, "recorder": 0}
    assert report["simulated_s"] == 0.2 and report["real_time_factor"] == pytest.approx(0.2 / report["wall_s"])
    direct(Run(**run, bag=str(tmp_path / "direct")))
    found, expected = contents(tmp_path / "up"), contents(tmp_path / "direct")
    assert {topic: len(messages) for topic, messages in found.items()} == dict.fromkeys(expected, 50)
    assert found == expected
    assert len({raw for _, raw in found[Topic.LEG_TARGETS]}) == 50


def test_a_node_that_refuses_ends_the_run_with_its_sentence(graph, tmp_path):
    foreign = tmp_path / "foreign.onnx"
    foreign.write_bytes(b"no network")
    with pytest.raises(NodeFailed, match=r"policy: .*foreign.onnx' is no policy"):
        up(Run(backend="simple", policy=str(foreign), seconds=1.0, bag=str(tmp_path / "bag")))


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"backend": "real"}, "There is no backend 'real'"),
        ({"backend": "residual"}, "give both or neither"),
        ({"backend": "full", "residual": "a.json"}, "give both or neither"),
        ({"policy": "a.onnx", "excitation": {"kind": "noise"}}, "either a policy or an excitation"),
    ],
)
def test_a_run_that_makes_no_sense_is_refused(options, said):
    with pytest.raises(ConfigError, match=said):
        Run(**options)


def test_launch_words_give_the_same_run():
    words = {
        "backend": "simple",
        "seconds": "2",
        "seed": "3",
        "friction": "",
        "excitation": "{kind: noise, seed: 1}",
        "real_time_factor": "0.0",
    }
    expected = Run(backend="simple", seconds=2.0, seed=3, excitation={"kind": "noise", "seed": 1}, real_time_factor=0.0)
    assert run_of_words(words) == expected
    with pytest.raises(ConfigError, match="seconds is 'soon'"):
        run_of_words({"seconds": "soon"})


def test_without_ros_a_run_needs_an_end():
    with pytest.raises(ConfigError, match="give its seconds"):
        direct(Run(backend="simple"))
