"""Stand-ins for what is large: the toy plant in the simulator node, a formula in the policy node. As executables:

python stand_ins.py simulator|policy --ros-args ...
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "controller"))

from toy import ToyEngine

from hamr_controller.ros.parameters import parameter
from hamr_controller.ros.process import run_node
from hamr_controller.ros.simulator import SimulatorNode
from hamr_controller.ros.simulator_parameters import SimulatorParameters
from hamr_policy import pilot, policy_node


@dataclass(frozen=True, slots=True)
class ToyParameters(SimulatorParameters):
    backend: str = parameter("", "taken for the graph's sake")
    residual: str = parameter("", "taken for the graph's sake")
    busy_us: float = parameter(0.0, "wall time of a substep")
    breaks_at: float = parameter(0.0, "s of sim time since reset at which the state becomes NaN; 0 for never")


class Sway:
    """A policy that depends on all it sees, so that one wrong bit anywhere spreads."""

    task = "walk"

    def reset(self) -> None:
        self._k = 0

    def act(self, sample: np.ndarray, base: np.ndarray, command: int) -> np.ndarray:
        self._k += 1
        swing = 0.1 * np.sin(0.3 * self._k + np.arange(8)) - 0.2 * sample[0] - 1e-4 * sample[1]
        return np.clip(command * (swing + 10.0 * base[:3].sum()), -0.4, 0.4)


def load(files: str) -> dict[str, Sway]:
    """In place of hamr_policy.pilot.load: any file name gives the formula."""
    return {"walk": Sway()} if files else {}


pilot.load = policy_node.load = load


def make_simulator(node, parameters, spinner, end=None) -> SimulatorNode:
    engine = ToyEngine(parameters.environment, parameters.busy_us, parameters.breaks_at)
    return SimulatorNode(node, parameters, spinner, engine, end)


def main() -> None:
    which = sys.argv.pop(1)
    if which == "policy":
        policy_node.main()
    else:
        run_node("simulator", ToyParameters, make_simulator)


if __name__ == "__main__":
    main()
