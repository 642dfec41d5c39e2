"""The step run from its traces, node by node on numpy arrays: at any step length, with every intermediate value at hand."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hamr_description.rates import SERVO_MS
from hamr_dynamics import layout, leg_stages
from hamr_dynamics.batch import DRIVE_SIGN, SIGN, BatchSim
from hamr_dynamics.chassis_stages import balance_free, balance_soft, predict
from hamr_dynamics.emit import Stage
from hamr_dynamics.trace import Var
from hamr_dynamics.walking_leg_stages import finish_legs, grounded, reach

OPERATIONS = {
    "add": np.add, "sub": np.subtract, "mul": np.multiply, "div": np.divide, "neg": np.negative, "sqrt": np.sqrt,
    "max": np.maximum, "min": np.minimum, "positive": lambda a: np.where(a > 0, 1.0, 0.0), "floor": np.floor,
}  # fmt: skip


def evaluate(stage: Stage, arrays: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Outputs (rows, lanes) of a stage from its inputs (rows, lanes)."""
    graph, values = stage.graph, {}
    where = {f"{array}.{row}": arrays[array][i] for array, names in stage.inputs.items() for i, row in enumerate(names)}
    for i in graph.needed(stage.values.values()):
        op, args = graph.nodes[i]
        values[i] = where[args[0]] if op == "input" else OPERATIONS[op](*(values[a] if isinstance(a, int) else a for a in args))
    lanes = next(iter(where.values())).shape

    def row(value) -> np.ndarray:
        return np.broadcast_to(values[value.index] if isinstance(value, Var) else value, lanes)

    return {array: np.array([row(stage.values[array, name]) for name in names]) for array, names in stage.outputs.items()}


class Interpreter:
    """The robots of a one-block BatchSim, in their present state.

    Attributes:
        arrays: name -> (rows, lanes) of the last step, as `hamr_dynamics.stages` lays them out.
    """

    def __init__(self, sim: BatchSim, h: float = SERVO_MS) -> None:
        assert sim.n == sim.block, "one block"
        self.n, self.ground, legs = sim.n, sim.environment == "ground", 4 * sim.n
        parts = {"state": (sim._state, legs), "param": (sim._param, legs), "base": (sim._base, sim.n), "body": (sim._body, sim.n)}
        self.arrays = {name: array[0].astype(float).reshape(-1, lanes) for name, (array, lanes) in parts.items()}
        plant = sim.plant
        if self.ground:
            self.chain: Sequence[Stage] = (
                predict(h), reach(plant, h), balance_soft(h), grounded(plant, h), balance_free(h), finish_legs(h),
            )  # fmt: skip
        else:
            self.chain = (leg_stages.suspended(plant, h),)

    def step(self, volts) -> None:
        """One step under (n, 8) V."""
        drive = (np.asarray(volts) - 112.5) * DRIVE_SIGN
        self.arrays["drive"] = drive.reshape(self.n, 4, 2).transpose(2, 1, 0).reshape(2, -1)
        for stage in self.chain:
            by_robot = any(name.startswith("fl.") for rows in (stage.inputs | stage.outputs).values() for name in rows)
            lanes = self.n if by_robot or "base" in stage.inputs else 4 * self.n
            found = evaluate(stage, {name: self.arrays[name].reshape(-1, lanes) for name in stage.inputs})
            self.arrays |= {name: x.reshape(-1, 4 * self.n) if "new_base" != name != "pose" else x for name, x in found.items()}
        self.arrays["state"] = self.arrays.pop("new_state")
        if self.ground:
            self.arrays["base"] = self.arrays.pop("new_base")

    def leg_rows(self, array: str, names: Sequence[str], name: str, size: int) -> np.ndarray:
        """(n, 4, size) of rows name.0 ... of a leg-lane array, in leg frames."""
        i = names.index(f"{name}.0" if size > 1 else name)
        return self.arrays[array][i : i + size].reshape(size, 4, self.n).transpose(2, 1, 0)

    def base_rows(self, name: str, size: int) -> np.ndarray:
        """(n, size) of the chassis state."""
        i = layout.BASE.index(f"{name}.0")
        return self.arrays["base"][i : i + size].T


class Seen:
    """An interpreter's robots with the attributes of the BatchSim that they came from."""

    def __init__(self, sim: BatchSim, robot: Interpreter) -> None:
        self._sim, self._robot = sim, robot

    def __getattr__(self, name: str):
        legs, bases = {"q": "q", "qd": "v"}, {"position": 3, "quaternion": 4, "velocity": 3, "angular_velocity": 3}
        if name in legs:
            return self._robot.leg_rows("state", layout.STATE, legs[name], 2).reshape(-1, 8) * SIGN
        if name in bases:
            return self._robot.base_rows("omega" if name == "angular_velocity" else name, bases[name])
        return getattr(self._sim, name)
