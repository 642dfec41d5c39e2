"""The simulator node with the toy plant inside, as an executable: python toy_simulator.py --ros-args ..."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "controller"))

from toy import ToyEngine  # noqa: E402

from hamr_controller.ros.parameters import parameter  # noqa: E402
from hamr_controller.ros.process import run_node  # noqa: E402
from hamr_controller.ros.simulator import SimulatorNode  # noqa: E402
from hamr_controller.ros.simulator_parameters import SimulatorParameters  # noqa: E402


@dataclass(frozen=True, slots=True)
class Parameters(SimulatorParameters):
    busy_us: float = parameter(0.0, "wall time of a substep")


def main() -> None:
    run_node("simulator", Parameters, lambda node, p, spinner: SimulatorNode(node, p, spinner, ToyEngine(p.environment, p.busy_us)))


if __name__ == "__main__":
    main()
