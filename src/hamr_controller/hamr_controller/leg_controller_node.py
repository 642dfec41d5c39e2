"""The node leg_controller: /leg_targets in, voltages on the servo bus at 20 kHz, /servo/voltages out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from rclpy.node import Node
from sensor_msgs.msg import JointState

from hamr_description.errors import ConfigError
from hamr_description.names import Topic

from .bus_ends import DriverEnd
from .law import Gains
from .leg_controller import LegController
from .messages import VoltageMessages
from .ros import qos
from .ros.driving import DrivingLoop
from .ros.parameters import follow, parameter
from .ros.ports import Diagnostics, Publishers
from .ros.process import Spinner, run_node
from .ros.run import RECORDER, TARGETS, BusParameters
from .targets import Targets

_GAINS = Gains.default()


@dataclass(frozen=True, slots=True)
class Parameters(BusParameters):
    """Parameters of the leg controller."""

    may_wait_for: ClassVar[tuple[str, ...]] = (TARGETS, RECORDER)

    kp: tuple[float, float] = parameter(_GAINS.kp, "gain on the hip angle, swing and lift, V/rad", live=True)
    kd: tuple[float, float] = parameter(_GAINS.kd, "gain on the hip rate, swing and lift, V s/rad", live=True)
    lockstep: bool = parameter(True, "let each period wait for the targets that answer its state")
    target_patience: float = parameter(0.5, "longest such wait, s of wall time")
    target_age: float = parameter(0.1, "oldest state that targets may answer, s of sim time")

    def __post_init__(self) -> None:
        BusParameters.__post_init__(self)
        if not all(gain >= 0 for gain in (*self.kp, *self.kd)):
            raise ConfigError(f"kp is {self.kp} and kd is {self.kd}; gains must be numbers that are not negative.")
        if not (self.target_patience > 0 and self.target_age > 0):
            raise ConfigError(f"target_patience is {self.target_patience} and target_age is {self.target_age}; both must be positive.")

    @property
    def gains(self) -> Gains:
        return Gains(self.kp, self.kd)


class LegControllerNode:
    """Wires a LegController to topics and bus.

    Attributes:
        driver: the controller itself.
        end: its end of the bus.
    """

    def __init__(self, node: Node, parameters: Parameters, spinner: Spinner):
        self._awaited, self._spinner = parameters.awaited, spinner
        self._diagnostics = Diagnostics(node)
        self._publishers = Publishers(node, [Topic.SERVO_VOLTAGES])
        targets = Targets(lockstep=parameters.lockstep, patience_s=parameters.target_patience, age_s=parameters.target_age)
        messages = VoltageMessages(parameters.samples_per_frame)
        self.driver = LegController(
            targets,
            parameters.gains,
            self._diagnostics.health,
            lambda time_ns, volts: self._publishers.send(Topic.SERVO_VOLTAGES, messages.voltages(time_ns, volts)),
        )
        self.end = DriverEnd(parameters.run)
        node.create_subscription(JointState, Topic.LEG_TARGETS, self._hear, qos.heard(Topic.LEG_TARGETS))
        follow(node, parameters, self._set)

    def run(self) -> None:
        """Drive the bus until the process is to stop."""
        DrivingLoop(
            self.end,
            self.driver,
            self._spinner,
            self._diagnostics,
            self._publishers,
            ready=self.ready,
            lossless=RECORDER in self._awaited,
        ).run()

    def _hear(self, message: JointState) -> None:
        stamp = message.header.stamp
        self.driver.hear(message.name, message.position, stamp.sec * 10**9 + stamp.nanosec, self.end.newest_period)

    def _set(self, parameters: Parameters) -> None:
        self.driver.gains = parameters.gains

    def ready(self) -> bool:
        """Whether the controller may begin: all that it waits for is there."""
        if RECORDER in self._awaited and not self._publishers.recorder_listens():
            return False
        return TARGETS not in self._awaited or self.driver.following


make = LegControllerNode


def main() -> None:
    """The executable."""
    run_node("leg_controller", Parameters, make)


if __name__ == "__main__":
    main()
