"""The node excitation: takes the controller's place on the servo bus and plays drive voltages, /servo/voltages out."""

from __future__ import annotations

import json
from dataclasses import dataclass

from rclpy.node import Node

from hamr_controller.bus_ends import DriverEnd
from hamr_controller.messages import VoltageMessages
from hamr_controller.player import Player
from hamr_controller.ros.driving import DrivingLoop
from hamr_controller.ros.parameters import parameter
from hamr_controller.ros.ports import Diagnostics, Publishers
from hamr_controller.ros.process import Spinner, run_node
from hamr_controller.ros.run import RECORDER, BusParameters
from hamr_description.errors import ConfigError
from hamr_description.names import Topic

from .excitation import Excitation, excitation


@dataclass(frozen=True, slots=True)
class Parameters(BusParameters):
    """Parameters of the excitation node."""

    excitation: str = parameter('{"kind": "noise"}', "the excitation, JSON: its kind, and the parameters of that kind")

    def signal(self) -> Excitation:
        """The voltages."""
        try:
            given = json.loads(self.excitation)
        except ValueError:
            given = None
        if not isinstance(given, dict):
            raise ConfigError(f"excitation is {self.excitation!r}; it must be a JSON object.")
        return excitation(**given)


class ExcitationNode:
    """Wires a Player to topics and bus.

    Attributes:
        driver: the player itself.
        end: its end of the bus.
    """

    def __init__(self, node: Node, parameters: Parameters, spinner: Spinner):
        self._spinner, self._lossless = spinner, RECORDER in parameters.awaited
        self._diagnostics = Diagnostics(node)
        self._publishers = Publishers(node, [Topic.SERVO_VOLTAGES])
        messages = VoltageMessages(parameters.samples_per_frame)
        self.driver = Player(
            parameters.signal(),
            self._diagnostics.health,
            lambda time_ns, volts: self._publishers.send(Topic.SERVO_VOLTAGES, messages.voltages(time_ns, volts)),
        )
        self.end = DriverEnd(parameters.run)

    def run(self) -> None:
        """Drive the bus until the process is to stop."""
        loop = DrivingLoop(
            self.end, self.driver, self._spinner, self._diagnostics, self._publishers, ready=self.ready, lossless=self._lossless
        )
        loop.run()

    def ready(self) -> bool:
        """Whether the signal may begin: the recorder listens, where one is awaited."""
        return not self._lossless or self._publishers.recorder_listens()


make = ExcitationNode


def main() -> None:
    """The executable."""
    run_node("excitation", Parameters, make)


if __name__ == "__main__":
    main()
