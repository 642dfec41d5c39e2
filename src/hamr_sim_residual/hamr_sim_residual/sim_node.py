"""The node sim: HAMR-simple behind the topics, with its learned residual or without."""

from __future__ import annotations

from dataclasses import dataclass

from rclpy.node import Node

from hamr_controller.ros.parameters import parameter
from hamr_controller.ros.process import Spinner, run_node
from hamr_controller.ros.simulator import SimulatorNode
from hamr_controller.ros.simulator_parameters import SimulatorParameters
from hamr_controller.simulation import End

from .engines import make_engine


@dataclass(frozen=True, slots=True)
class Parameters(SimulatorParameters):
    """Those of every simulator, and which model runs."""

    residual: str = parameter("", "residual model file; empty for plain HAMR-simple")
    backend: str = parameter("", "simple, simple_published or residual; empty for what 'residual' says")


def make(node: Node, parameters: Parameters, spinner: Spinner, end: End | None = None) -> SimulatorNode:
    """The node with its robot; see SimulatorNode."""
    p = parameters
    engine = make_engine(
        backend=p.backend, engine=p.engine, environment=p.environment, friction=p.friction, residual=p.residual, effects=p.effects,
        seed=p.seed,
    )  # fmt: skip
    return SimulatorNode(node, p, spinner, engine, end)


def main() -> None:
    """The executable."""
    run_node("simulator", Parameters, make)


if __name__ == "__main__":
    main()
