"""Pause, step, reset, and parameters while nodes run."""

from __future__ import annotations

from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import GetParameters, SetParameters
from std_srvs.srv import SetBool, Trigger

from hamr_description.names import Topic
from hamr_description.rates import TARGET_NS


def ns(stamp) -> int:
    return stamp.sec * 10**9 + stamp.nanosec


def double(name: str, *values: float, array: bool = False) -> Parameter:
    if array:
        return Parameter(name=name, value=ParameterValue(type=ParameterType.PARAMETER_DOUBLE_ARRAY, double_array_value=list(values)))
    return Parameter(name=name, value=ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=values[0]))


def test_pause_step_reset_and_parameters(graph, observe):
    graph.start("simulator", seed=3)
    controller = graph.start("leg_controller", kp=[100.0, 100.0])
    observer = observe(Topic.CLOCK, Topic.JOINT_STATES, Topic.SERVO_VOLTAGES)
    states = observer.heard[Topic.JOINT_STATES]

    def trigger(what: str) -> Trigger.Response:
        return observer.call(Trigger, f"/simulator/{what}", Trigger.Request())

    def pause(on: bool) -> None:
        assert observer.call(SetBool, "/simulator/pause", SetBool.Request(data=on)).success

    observer.next(Topic.JOINT_STATES)
    assert not trigger("step").success  # only while paused
    pause(True)
    last = None
    while last != (last := states[-1].header.stamp):  # what was under way has come
        observer.call(GetParameters, "/simulator/get_parameters", GetParameters.Request(names=["seed"]))
    for step in range(1, 4):
        assert trigger("step").success
        observer.until(lambda step=step: ns(states[-1].header.stamp) >= ns(last) + step * TARGET_NS, "the next state")
        assert ns(states[-1].header.stamp) == ns(last) + step * TARGET_NS

    moved = list(states[-1].position)
    before = ns(states[-1].header.stamp)
    assert trigger("reset").success
    observer.until(lambda: ns(states[-1].header.stamp) > before, "the state after the reset")
    assert ns(states[-1].header.stamp) == before + 2 * TARGET_NS  # the clock goes on, and everyone sees the cut
    fresh = list(states[-1].position)
    assert fresh != moved and list(states[-1].velocity) == [0.0] * 8
    assert trigger("reset").success
    observer.until(lambda: ns(states[-1].header.stamp) > before + 2 * TARGET_NS, "the state after another reset")
    assert list(states[-1].position) == fresh  # same seed, same start

    pause(False)
    observer.next(Topic.SERVO_VOLTAGES, lambda frame: ns(frame.header.stamp) > before + 50 * TARGET_NS)
    clock = [ns(message.clock) for message in observer.heard[Topic.CLOCK]]
    assert clock == sorted(clock)

    def set_parameter(node: str, parameter: Parameter):
        return observer.call(SetParameters, f"/{node}/set_parameters", SetParameters.Request(parameters=[parameter])).results[0]

    def get(node: str, name: str) -> ParameterValue:
        return observer.call(GetParameters, f"/{node}/get_parameters", GetParameters.Request(names=[name])).values[0]

    assert list(get("leg_controller", "kp").double_array_value) == [100.0, 100.0]
    assert set_parameter("leg_controller", double("kp", 200.0, 150.0, array=True)).successful
    assert list(get("leg_controller", "kp").double_array_value) == [200.0, 150.0]
    refused = set_parameter("leg_controller", double("kp", -1.0, 150.0, array=True))
    assert not refused.successful and "not negative" in refused.reason
    assert list(get("leg_controller", "kp").double_array_value) == [200.0, 150.0]
    assert not set_parameter("leg_controller", double("target_age", 1.0)).successful  # read-only
    assert set_parameter("simulator", double("real_time_factor", 0.0)).successful
    start = ns(observer.next(Topic.CLOCK).clock)
    observer.next(Topic.CLOCK, lambda message: ns(message.clock) > start + 4 * 10**9)  # far ahead of wall time
    assert "Traceback" not in controller.said
