"""A bad message never moves the robot, and is named in /diagnostics and in the log."""

from __future__ import annotations

from math import inf, nan

from geometry_msgs.msg import Twist
from harness import until
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState

from hamr_controller.ros import qos
from hamr_description.names import JOINTS, Topic

ZERO = [0.0] * 8
#: What must be said -> names, positions, age of the stamp in s of sim time.
BAD = {
    "'nose', which is no joint": (["nose", *JOINTS[1:]], [0.2] * 8, 0),
    "lacks 'rr_lift'": (JOINTS[:7], [0.2] * 7, 0),
    "names 'fl_lift' 2 times": ([JOINTS[1], *JOINTS[1:]], [0.2] * 8, 0),
    "3 values for 8 joints": (JOINTS, [0.2] * 3, 0),
    "nan for 'rl_swing'": (JOINTS, [0.2, 0.2, nan, 0.2, 0.2, 0.2, 0.2, 0.2], 0),
    "-inf for 'fl_swing'": (JOINTS, [-inf, *ZERO[1:]], 0),
    "0.5 rad for 'fr_swing'": (JOINTS, [0.2, 0.2, 0.2, 0.2, 0.5, 0.2, 0.2, 0.2], 0),
    "stale at": (JOINTS, [0.2] * 8, 0.2),
    "give targets the stamp of the newest": (JOINTS, [0.2] * 8, -100.0),  # of the future
}


def neutral(frame) -> bool:
    return all(volt == 112.5 for point in frame.points for volt in point.effort)


def test_bad_targets(graph, observe):
    simulator, controller = graph.start("simulator", wait_for="driver"), graph.start("leg_controller", lockstep=False)
    observer = observe(Topic.SERVO_VOLTAGES, Topic.JOINT_STATES, Topic.DIAGNOSTICS)
    publisher = observer.node.create_publisher(JointState, Topic.LEG_TARGETS, qos.sent(Topic.LEG_TARGETS))
    observer.until(publisher.get_subscription_count, "the controller on /leg_targets")
    observer.next(Topic.JOINT_STATES, lambda state: state.header.stamp.sec >= 1)

    def send(names, position, age=0.0) -> None:
        stamp = observer.newest(Topic.JOINT_STATES).header.stamp
        ns = stamp.sec * 10**9 + stamp.nanosec - round(age * 1e9)
        message = JointState(name=list(names), position=list(position))
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(ns, 10**9)
        publisher.publish(message)

    observer.heard[Topic.SERVO_VOLTAGES].clear()
    frames = []
    for said, (names, position, age) in BAD.items():
        send(names, position, age)
        observer.until(lambda said=said: said in controller.said, f"'{said}' in the log")
        frames += observer.heard[Topic.SERVO_VOLTAGES]
    assert frames and all(neutral(frame) for frame in frames)
    named = observer.status("leg_controller", lambda status: all(said in status.message for said in BAD))
    assert named.level == b"\x01" and dict((v.key, v.value) for v in named.values)["refused"] == str(len(BAD))
    observer.heard[Topic.SERVO_VOLTAGES].clear()

    def moves() -> bool:
        send(JOINTS, [0.2] * 8)  # the same way, but good; again where it came late and was stale
        return not all(neutral(frame) for frame in observer.heard[Topic.SERVO_VOLTAGES])

    observer.until(moves, "voltages that answer good targets")
    observer.next(Topic.SERVO_VOLTAGES, neutral)  # and no more came: neutral again
    assert "Traceback" not in controller.said + simulator.said


def test_bad_commands_and_states_for_the_policy(graph, observe):
    """The observer plays the simulator here: it sends states and hears targets."""
    policy = graph.start("policy", policy="any")
    observer = observe(Topic.LEG_TARGETS, Topic.DIAGNOSTICS)
    publishers = {
        topic: observer.node.create_publisher(kind, topic, qos.sent(topic))
        for kind, topic in ((Twist, Topic.CMD_VEL), (Odometry, Topic.ODOM), (JointState, Topic.JOINT_STATES))
    }
    for publisher in publishers.values():
        observer.until(publisher.get_subscription_count, "the policy on its topics")
    period = 0

    def answer(names=JOINTS, x: float = 0.0) -> list[float]:
        """Targets that answer a new state, sent until they come, as the simulator does."""
        nonlocal period
        period += 1
        odometry, joints = Odometry(), JointState(name=list(names), position=ZERO, velocity=ZERO)
        odometry.pose.pose.position.x = x
        for message in (odometry, joints):
            message.header.stamp.nanosec = period * 4_000_000
        observer.heard[Topic.LEG_TARGETS].clear()

        def send_again() -> None:
            publishers[Topic.ODOM].publish(odometry)
            publishers[Topic.JOINT_STATES].publish(joints)
            observer.spin()

        def answers() -> list[JointState]:
            return [message for message in observer.heard[Topic.LEG_TARGETS] if message.header.stamp == joints.header.stamp]

        fresh = until(answers, "targets", send_again)
        assert all(list(m.position) == list(fresh[0].position) for m in fresh)  # a state sent again has the same answer
        return list(fresh[0].position)

    def command(forward: float, turn: float, said: str) -> None:
        twist = Twist()
        twist.linear.x, twist.angular.z = forward, turn
        publishers[Topic.CMD_VEL].publish(twist)
        observer.until(lambda: said in policy.said, f"'{said}' in the log")
        assert answer() == ZERO

    assert answer() == ZERO  # no command: stand
    command(nan, 0.0, "linear.x nan")
    command(0.1, 0.1, "walk and turn at once")
    command(0.0, 1.0, "needs a policy for 'turn', but only 'walk' is loaded")
    good = Twist()
    good.linear.x = 0.1
    publishers[Topic.CMD_VEL].publish(good)
    observer.until(lambda: answer() != ZERO, "a walk")

    names = list(JOINTS)
    publishers[Topic.JOINT_STATES].publish(JointState(name=["nose", *names[1:]], position=ZERO, velocity=ZERO))
    observer.until(lambda: "/joint_states names 'nose'" in policy.said, "a wrong joint in the log")
    odometry = Odometry()
    odometry.pose.pose.position.x = nan
    publishers[Topic.ODOM].publish(odometry)
    observer.until(lambda: "/odom holds numbers that are not finite" in policy.said, "NaN in the log")
    status = observer.status("policy")
    assert status.level == b"\x01" and "'nose'" in status.message and "/odom" in status.message
    observer.until(lambda: answer() == ZERO, "silence: stand again")
    assert "Traceback" not in policy.said
