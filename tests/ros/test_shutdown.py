"""Ctrl-C ends everything in order, more of it does no harm, and no node outlives its supervisor."""

from __future__ import annotations

import json
import signal
import sys
from pathlib import Path

from harness import until

from hamr_bags.reader import load
from hamr_description.names import Topic
from hamr_description.rates import TARGET_HZ

UP = """
import json, os, sys
from hamr_bringup.graph import Run
from hamr_bringup.supervisor import up
excitation = {"kind": "noise", "seconds": 60.0}
run = Run(backend="simple", environment="suspended", excitation=excitation, bag=sys.argv[1], seconds=60.0)
sys.stdout.write(json.dumps(up(run)))
"""


def processes() -> dict[int, str]:
    """Command lines of all processes."""
    found = {}
    for folder in Path("/proc").iterdir():
        if folder.name.isdigit():
            try:
                found[int(folder.name)] = (folder / "cmdline").read_bytes().replace(b"\0", b" ").decode()
            except OSError:
                continue
    return found


def children_of(supervisor: int) -> set[int]:
    return {pid for pid, line in processes().items() if f"hamr_bringup.child {supervisor} " in line}


def test_ctrl_c_ends_the_graph_in_order_with_a_readable_bag(graph, observe, tmp_path):
    bag = tmp_path / "bag"
    supervisor = graph.run("up", sys.executable, "-c", UP, str(bag))
    observe(Topic.SERVO_VOLTAGES).next(Topic.SERVO_VOLTAGES, lambda frame: frame.header.stamp.nanosec > 0.2e9)
    supervisor.signal(signal.SIGINT)
    supervisor.signal(signal.SIGINT)
    assert supervisor.ended() == 0, supervisor.said
    result = json.loads(supervisor.said[supervisor.said.index('{"domain') :])
    assert result["nodes"] == {"simulator": 0, "excitation": 0, "recorder": 0}  # nobody had to be killed, which comes after 1.8 s
    assert "Traceback" not in supervisor.said
    recording = load(bag)
    assert len(recording) == round(result["simulated_s"] * TARGET_HZ) * 16  # every sample that was simulated is in the bag
    assert len(recording.pieces) == 1


def test_nodes_do_not_outlive_their_supervisor(graph, observe, tmp_path):
    supervisor = graph.run("up", sys.executable, "-c", UP, str(tmp_path / "bag"))
    observe(Topic.SERVO_VOLTAGES).next(Topic.SERVO_VOLTAGES)
    assert len(children_of(supervisor.popen.pid)) == 3
    supervisor.kill()
    until(lambda: not children_of(supervisor.popen.pid), "the end of the nodes")
    assert len(load(tmp_path / "bag")) > 0


def test_no_number_of_signals_upsets_a_node(graph, observe, tmp_path):
    observer = observe()
    nodes = [
        graph.start("simulator"),
        graph.start("leg_controller"),
        graph.start("policy"),
        graph.start("recorder", bag=str(tmp_path / "bag")),
    ]
    names = {"simulator", "leg_controller", "policy", "recorder"}
    observer.until(lambda: names <= set(observer.node.get_node_names()), "all four nodes")
    for node in nodes:
        until(lambda node=node: node.popen.poll() is not None, "the end", lambda node=node: node.signal(signal.SIGINT))
        assert node.ended() == 0 and "Traceback" not in node.said, node.said
