"""Lock-step: every state is answered before time goes on, even where messages get lost, and time never goes on from a broken state."""

from __future__ import annotations

from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from hamr_controller.ros import qos
from hamr_description.names import JOINTS, Topic

PERIODS = 10


def ns(stamp) -> int:
    return stamp.sec * 10**9 + stamp.nanosec


def test_a_state_that_gets_lost_is_sent_again_and_no_period_goes_unanswered(graph, observe):
    """The observer is the policy, and deaf to the first copy of every state."""
    graph.start("simulator", wait_for="driver", real_time_factor=0.0)
    graph.start("leg_controller", wait_for="targets", target_patience=30.0)
    observer = observe(Topic.JOINT_STATES, Topic.SERVO_VOLTAGES)
    publisher = observer.node.create_publisher(JointState, Topic.LEG_TARGETS, qos.sent(Topic.LEG_TARGETS))
    heard: list[int] = []

    def answer_second_copies() -> bool:
        for state in observer.heard[Topic.JOINT_STATES]:
            if ns(state.header.stamp) in heard:  # this is no first copy; an answer may get lost as well
                targets = JointState(header=state.header, name=list(JOINTS), position=[0.1] * 8)
                publisher.publish(targets)
                publisher.publish(targets)  # an answer sent twice does no harm either
            heard.append(ns(state.header.stamp))
        observer.heard[Topic.JOINT_STATES].clear()
        return len(set(heard)) > PERIODS

    observer.until(answer_second_copies, "ten periods")
    stamps = list(dict.fromkeys(heard))
    assert stamps == [k * 4_000_000 for k in range(len(stamps))]
    frames = observer.heard[Topic.SERVO_VOLTAGES]
    observer.until(lambda: len(frames) >= PERIODS, "the frames of all periods")
    assert [ns(frame.header.stamp) for frame in frames[:PERIODS]] == stamps[:PERIODS]
    for frame in frames[:PERIODS]:
        assert any(volt != 112.5 for volt in frame.points[0].effort)


def test_time_stands_still_at_a_state_that_is_not_finite_until_the_reset(graph, observe):
    simulator = graph.start("simulator", breaks_at=0.1, real_time_factor=0.0)
    observer = observe(Topic.CLOCK, Topic.JOINT_STATES, Topic.DIAGNOSTICS)
    broken = observer.status("simulator", lambda status: status.level == b"\x02")
    assert "not finite at 0.100 s: reset it." in broken.message
    assert observer.call(Trigger, "/simulator/reset", Trigger.Request()).success
    observer.until(lambda: "not finite at 0.208 s" in simulator.said, "the next such state, 0.1 s after a clock that went on")
    heard = observer.heard
    observer.until(lambda: heard[Topic.JOINT_STATES] and ns(heard[Topic.CLOCK][-1].clock) == 204_000_000, "the last states")
    positions = [value for state in observer.heard[Topic.JOINT_STATES] for value in state.position]
    assert positions and all(value == value for value in positions)  # nobody ever got to see a NaN
    stamps = [ns(message.clock) for message in observer.heard[Topic.CLOCK]]
    assert stamps == sorted(set(stamps)) and stamps[-1] < 208_000_000
