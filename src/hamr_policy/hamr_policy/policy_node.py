"""The node policy: answers each state of the robot with target hip angles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rclpy.node import Node
from sensor_msgs.msg import JointState

from hamr_controller.joints import BadMessage, ordered
from hamr_controller.messages import BASE_SIZE, POSITION, ROWS, VELOCITY, TargetMessages
from hamr_controller.ros import qos
from hamr_controller.ros.parameters import parameter
from hamr_controller.ros.ports import Diagnostics, Publishers
from hamr_controller.ros.process import SLICE_S, Spinner, run_node
from hamr_controller.ros.run import RECORDER, RunParameters
from hamr_description.errors import ConfigError
from hamr_description.names import JOINTS, Topic

from .pilot import Pilot, command_named, load


@dataclass(frozen=True, slots=True)
class Parameters(RunParameters):
    """Parameters of the policy node."""

    policy: str = parameter("", "policy files, with commas, one a task; empty to stand still")
    command: str = parameter("", "what to do until /cmd_vel says otherwise: forward, backward, left, right, or nothing")
    silence: float = parameter(0.5, "s of sim time after which a /cmd_vel that is not repeated counts as zero")

    def __post_init__(self) -> None:
        RunParameters.__post_init__(self)
        command_named(self.command)
        if not self.silence > 0:
            raise ConfigError(f"silence is {self.silence}; it must be a positive number of seconds.")


class PolicyNode:
    """Wires a Pilot to the topics: a state is complete when /odom and /joint_states have come with one stamp."""

    def __init__(self, node: Node, parameters: Parameters, spinner: Spinner):
        self._spinner = spinner
        self._pilot = Pilot(load(parameters.policy), silence_s=parameters.silence, command=command_named(parameters.command))
        self._diagnostics = Diagnostics(node)
        self._publishers = Publishers(node, [Topic.LEG_TARGETS])
        self._messages = TargetMessages()
        self._awaits_recorder = RECORDER in parameters.awaited
        self._sample, self._base = np.full((ROWS, len(JOINTS)), np.nan), np.zeros(BASE_SIZE)
        self._odometry_ns = self._joints_ns = self._answered_ns = -1
        self._answer = b""
        for kind, topic, hear in (
            (Odometry, Topic.ODOM, self._hear_odometry),
            (JointState, Topic.JOINT_STATES, self._hear_joints),
            (Twist, Topic.CMD_VEL, self._hear_command),
        ):
            node.create_subscription(kind, topic, hear, qos.heard(topic))

    def run(self) -> None:
        """Answer until the process is to stop."""
        while not self._spinner.stopping:
            self._spinner.once(SLICE_S)
            self._diagnostics.tick(max(0, self._answered_ns), lambda: None)
        self._publishers.settle(0.5)

    def _hear_odometry(self, message: Odometry) -> None:
        pose, twist = message.pose.pose, message.twist.twist
        p, q, v, w = pose.position, pose.orientation, twist.linear, twist.angular
        base = np.array([p.x, p.y, p.z, q.x, q.y, q.z, q.w, v.x, v.y, v.z, w.x, w.y, w.z])
        if not np.isfinite(base).all():
            self._diagnostics.health.refuse(f"{Topic.ODOM} holds numbers that are not finite; correct what publishes it.")
            return
        self._base = base
        self._odometry_ns = _ns(message)
        self._answer_state()

    def _hear_joints(self, message: JointState) -> None:
        try:
            self._sample[POSITION] = ordered(Topic.JOINT_STATES, message.name, message.position)
            self._sample[VELOCITY] = ordered(Topic.JOINT_STATES, message.name, message.velocity)
        except BadMessage as error:
            self._diagnostics.health.refuse(str(error))
            return
        self._joints_ns = _ns(message)
        self._answer_state()

    def _hear_command(self, message: Twist) -> None:
        try:
            self._pilot.command(message.linear.x, message.angular.z)
        except ConfigError as error:
            self._diagnostics.health.refuse(str(error))

    def _answer_state(self) -> None:
        if self._odometry_ns != self._joints_ns:
            return
        if self._awaits_recorder:
            if not self._publishers.recorder_listens():
                return  # the state comes again
            self._awaits_recorder = False
        if self._joints_ns != self._answered_ns:  # else the state was sent again: so is its answer
            targets = self._pilot.answer(self._joints_ns, self._sample, self._base)
            self._answer, self._answered_ns = self._messages.targets(self._joints_ns, targets), self._joints_ns
        self._publishers.send(Topic.LEG_TARGETS, self._answer)


def _ns(message: Odometry | JointState) -> int:
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


make = PolicyNode


def main() -> None:
    """The executable."""
    run_node("policy", Parameters, make)


if __name__ == "__main__":
    main()
