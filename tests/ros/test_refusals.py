"""What does not fit is refused at the start: one sentence, status 1, no traceback."""

from __future__ import annotations

import sys

import pytest
import rclpy
from rclpy.node import Node

from hamr_bags import excitation_node, recorder_node
from hamr_controller import leg_controller_node
from hamr_controller.ros import parameters
from hamr_controller.ros.process import new_node
from hamr_controller.ros.simulator_parameters import SimulatorParameters
from hamr_description.errors import ConfigError
from hamr_policy import policy_node

CONTROLLER, POLICY = leg_controller_node.Parameters, policy_node.Parameters
MISTAKES = [
    (CONTROLLER, {"kpp": 1.0}, r"test has no parameter 'kpp'; it takes .*kp, kd"),
    (CONTROLLER, {"kp": [1.0]}, r"Parameter 'kp' is \[1.0\]; give it as 2 numbers"),
    (CONTROLLER, {"kp": ["a", "b"]}, r"Parameter 'kp' is 'a'; give it as float"),
    (CONTROLLER, {"lockstep": "maybe"}, "Parameter 'lockstep' is 'maybe'; give it as bool"),
    (CONTROLLER, {"kd": [-1.0, 1.0]}, "gains must be numbers that are not negative"),
    (CONTROLLER, {"kd": [float("nan"), 1.0]}, "gains must be numbers that are not negative"),
    (CONTROLLER, {"target_age": 0.0}, "must be positive"),
    (CONTROLLER, {"wait_for": "targets,nobody"}, "wait_for names 'nobody'; this node can wait for targets and recorder"),
    (CONTROLLER, {"samples_per_frame": 7}, "samples_per_frame is 7; choose one of 1, 2"),
    (SimulatorParameters, {"friction": 99.0}, "friction is 99.0; choose"),
    (SimulatorParameters, {"environment": "water"}, "environment is 'water'; choose one of ground, suspended"),
    (SimulatorParameters, {"real_time_factor": -1.0}, "must not be negative"),
    (SimulatorParameters, {"excitation": "[]"}, "it must be a JSON object"),
    (recorder_node.Parameters, {}, "The recorder has no parameter bag"),
    (POLICY, {"command": "fly"}, "There is no command 'fly'; choose one of forward, backward, left, right"),
    (POLICY, {"silence": 0.0}, "it must be a positive number"),
]


@pytest.fixture
def ros(graph):
    rclpy.init()
    yield
    rclpy.shutdown()


def test_every_mistake_is_one_sentence_that_names_it(ros):
    for kind, given, said in MISTAKES:
        with pytest.raises(ConfigError, match=said) as error:
            new_node("test", kind, given)
        assert str(error.value).endswith(".") and "\n" not in str(error.value)
    for text in ("noise", '{"kind": "tickle"}', '{"kind": "noise", "colour": 1}'):
        with pytest.raises(ConfigError, match="(?i)excitation"):
            excitation_node.Parameters(excitation=text).signal()


def test_whole_numbers_are_taken_for_real_ones_and_the_rest_are_the_defaults(ros):
    node, given = new_node("test", CONTROLLER, {"kp": [100, 200], "target_age": 1})
    assert given == CONTROLLER(kp=(100.0, 200.0), target_age=1.0)
    assert list(node.get_parameter("kp").value) == [100.0, 200.0] and node.get_parameter("lockstep").value is True


@pytest.mark.parametrize(
    ("key", "said"),
    [
        ("leg_controller", ""),
        ("/**", ""),
        ("/leg_controller", ""),
        ("leg_controler", r"no parameters for /leg_controller; it names leg_controler\."),
    ],
)
def test_a_parameter_file_must_speak_to_the_node(ros, tmp_path, key, said):
    file = tmp_path / "parameters.yaml"
    file.write_text(f'"{key}":\n  ros__parameters:\n    lockstep: false\n')
    node = Node("leg_controller", automatically_declare_parameters_from_overrides=True)
    arguments = ["node", "--ros-args", "--params-file", str(file)]
    if said:
        with pytest.raises(ConfigError, match=said):
            parameters.load(node, CONTROLLER, arguments)
    else:
        parameters.load(node, CONTROLLER, arguments)


def test_processes_end_with_status_one_and_nothing_but_the_sentence(graph, tmp_path):
    running = graph.start("simulator", run="taken")
    recorder = [sys.executable, "-m", "hamr_bags.recorder_node"]
    mistakes = {
        "leg_controller: leg_controller has no parameter 'kpp'; it takes": graph.start("leg_controller", kpp=1.0),
        "recorder: There is no argument '--fast'; write": graph.run("x", *recorder, "--fast"),
        "recorder: ROS cannot read the arguments: ": graph.run("y", *recorder, "--ros-args", "-p", "bag=out"),
        f"recorder: {tmp_path} exists already; choose another name": graph.start("recorder", bag=str(tmp_path)),
    }
    for sentence, process in mistakes.items():
        assert process.ended() == 1, process.said
        assert process.said.startswith(sentence) and process.said.count("\n") == 1, process.said
    second = graph.start("simulator", run="taken")
    assert second.ended() == 1 and f"A simulator (process {running.popen.pid}) already runs" in second.said
    assert running.popen.poll() is None
