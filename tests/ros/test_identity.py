"""The same run as processes, in one process and without ROS: every message on every topic is the same to the byte."""

from __future__ import annotations

import json
import signal
import sys
from pathlib import Path

import pytest
from harness import Process, contents

from hamr_bringup.graph import Run
from hamr_bringup.graph import graph as graph_of
from hamr_description.names import Topic

HERE = Path(__file__).parent
PERIODS = 100
RUNS = {
    "policy": {"policy": "any", "command": "forward"},
    "excitation": {"excitation": {"kind": "noise", "seconds": 0.3, "seed": 5, "band_hz": 100.0}, "samples_per_frame": 80},
}
#: Runs `composed` or `direct` with the stand-ins, in a process of its own.
ONE_PROCESS = """
import json, sys
sys.path.insert(0, sys.argv[1])
import stand_ins
from stand_ins import ToyParameters, make_simulator
from hamr_bringup import direct as without
without.load = stand_ins.load
from hamr_bringup.graph import Run
from hamr_sim_full import sim_node
sim_node.Parameters, sim_node.make = ToyParameters, make_simulator
run = Run(**json.loads(sys.argv[3]))
if sys.argv[2] == "direct":
    without.direct(run, engine=stand_ins.ToyEngine(run.environment))
else:
    from hamr_bringup.composed import composed
    composed(run)
"""


@pytest.mark.parametrize("kind", RUNS)
def test_three_ways_one_result(kind, graph, tmp_path):
    options = {**RUNS[kind], "seconds": PERIODS * 0.004, "real_time_factor": 0.0, "seed": 2}

    def in_one_process(way: str) -> Process:
        return graph.run(way, sys.executable, "-c", ONE_PROCESS, str(HERE), way, json.dumps({**options, "bag": str(tmp_path / way)}))

    direct = in_one_process("direct")
    simulator, *others = [graph.start_spec(spec) for spec in graph_of(Run(**options, bag=str(tmp_path / "processes")))]
    assert simulator.ended() == 0, simulator.said
    for node in others:
        assert node.signal(signal.SIGINT).ended() == 0, node.said
    for process in (direct, in_one_process("composed")):
        assert process.ended() == 0, process.said
    expected = contents(tmp_path / "direct")
    wanted = {Topic.CLOCK, Topic.ODOM, Topic.JOINT_STATES, Topic.SERVO_JOINTS, Topic.SERVO_ACTUATORS, Topic.SERVO_VOLTAGES}
    assert set(expected) == wanted | ({Topic.LEG_TARGETS} if kind == "policy" else set())
    assert all(len(messages) == PERIODS for messages in expected.values())
    assert len({raw for _, raw in expected[Topic.JOINT_STATES]}) == PERIODS  # it does move
    for way in ("composed", "processes"):
        found = contents(tmp_path / way)
        assert found.keys() == expected.keys()
        for topic in expected:
            assert found[topic] == expected[topic], f"{topic} differs: {way}"
