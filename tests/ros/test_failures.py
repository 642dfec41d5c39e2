"""Every node may be killed with -9: the others stay safe, say so, and go on when it returns."""

from __future__ import annotations

from hamr_description.names import Topic


def neutral(frame) -> bool:
    return all(volt == 112.5 for point in frame.points for volt in point.effort)


def at_rest(frame) -> bool:
    """No drive torque: what neutral voltage means in the plant."""
    return all(torque == 0.0 for point in frame.points for torque in point.effort)


def test_each_node_is_killed_and_comes_back(graph, observe):
    observer = observe(Topic.SERVO_VOLTAGES, Topic.SERVO_JOINTS, Topic.DIAGNOSTICS)
    parts = {
        "simulator": {"wait_for": "driver", "real_time_factor": 1.0},
        "leg_controller": {"wait_for": "targets"},
        "policy": {"policy": "any", "command": "forward"},
    }
    nodes = {name: graph.start(name, **parameters) for name, parameters in parts.items()}

    def walks(frame) -> bool:
        return not neutral(frame)

    observer.next(Topic.SERVO_VOLTAGES, walks)

    nodes["policy"].kill()
    observer.next(Topic.SERVO_VOLTAGES, neutral)
    assert "No targets on /leg_targets: neutral voltage." in observer.status("leg_controller", lambda s: s.level == b"\x01").message
    nodes["policy"] = graph.start("policy", **parts["policy"])
    observer.next(Topic.SERVO_VOLTAGES, walks)

    nodes["leg_controller"].kill()
    observer.next(Topic.SERVO_JOINTS, at_rest)
    assert "gone or silent: neutral voltage" in observer.status("simulator", lambda s: s.level == b"\x01").message
    nodes["leg_controller"] = graph.start("leg_controller", **parts["leg_controller"])
    observer.next(Topic.SERVO_VOLTAGES, walks)
    observer.next(Topic.SERVO_JOINTS, lambda frame: not at_rest(frame))
    assert observer.status("simulator", lambda s: s.level == b"\x00").message == "ok"

    nodes["simulator"].kill()
    assert observer.status("leg_controller", lambda s: "No simulator" in s.message).level == b"\x01"
    nodes["simulator"] = graph.start("simulator", **parts["simulator"])
    observer.next(Topic.SERVO_VOLTAGES, lambda frame: walks(frame) and frame.header.stamp.sec == 0)  # a new simulator is a new clock
    for name, process in nodes.items():
        assert process.popen.poll() is None, name
        assert "Traceback" not in process.said
