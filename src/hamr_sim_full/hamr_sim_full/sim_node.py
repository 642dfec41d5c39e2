"""The node sim: HAMR-full behind the topics."""

from __future__ import annotations

from rclpy.node import Node

from hamr_controller.ros.process import Spinner, run_node
from hamr_controller.ros.simulator import SimulatorNode
from hamr_controller.ros.simulator_parameters import SimulatorParameters as Parameters
from hamr_controller.simulation import End

from .engines import make_engine


def make(node: Node, parameters: Parameters, spinner: Spinner, end: End | None = None) -> SimulatorNode:
    """The node with its robot; see SimulatorNode."""
    p = parameters
    engine = make_engine(engine=p.engine, environment=p.environment, friction=p.friction, effects=p.effects, seed=p.seed)
    return SimulatorNode(node, p, spinner, engine, end)


def main() -> None:
    """The executable."""
    run_node("simulator", Parameters, make)


if __name__ == "__main__":
    main()
