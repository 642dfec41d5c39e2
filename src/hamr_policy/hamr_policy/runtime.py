"""Policies at work: an ONNX file in, target hip angles out, in microseconds and without torch."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import onnxruntime

from hamr_description.errors import ModelError

from .observation import observe, place
from .policy_file import INPUT, KEY, OUTPUT, check
from .state import State
from .task import TARGET_LIMIT


class Policy:
    """A policy file, opened and checked.

    Attributes:
        about: what the file says: task, view, backend, seed, ... (`policy_file.interface`, `export.Origin`).
    """

    def __init__(self, path: str | Path) -> None:
        if not Path(path).is_file():
            raise ModelError(f"There is no policy file '{path}': give the path of a file that `hamr train policy` wrote.")
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1  # one thread: deterministic, and faster at this size
        options.log_severity_level = 4
        try:
            self._session = onnxruntime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])
        except Exception as error:  # whatever onnxruntime says of a file that it cannot read
            raise ModelError(f"'{path}' is no policy: it is not a readable ONNX file.") from error
        self.about = check(path, self._session.get_modelmeta().custom_metadata_map.get(KEY))
        shape = [(x.name, x.shape[-1], x.type) for x in (*self._session.get_inputs(), *self._session.get_outputs())]
        sizes = len(self.about["observation"]), len(self.about["action"]["joints"])
        if shape != [(INPUT, sizes[0], "tensor(float)"), (OUTPUT, sizes[1], "tensor(float)")]:
            raise ModelError(f"Policy '{path}' does not have the input and output that it describes: train it anew.")

    def targets(self, observations: np.ndarray) -> np.ndarray:
        """(n, 8) rad, float64, within the limit, for observations (n, size) float32."""
        targets = self._session.run([OUTPUT], {INPUT: observations})[0].astype(float)
        return np.clip(targets, -TARGET_LIMIT, TARGET_LIMIT)  # the limit in single precision can lie above the limit


class PolicyRuntime:
    """One policy driving one robot.

    Attributes:
        task: what it can do, key of `task.TASKS`.
    """

    def __init__(self, path: str | Path) -> None:
        """Opens a policy file; ModelError says in one sentence why it does not fit this robot."""
        self._policy = Policy(path)
        self.task: str = self._policy.about["task"]
        self._start: np.ndarray | None = None

    def reset(self) -> None:
        """A primitive begins at the next state."""
        self._start = None

    def act(self, sample: np.ndarray, base: np.ndarray, command: int) -> np.ndarray:
        """Targets (8,) rad.

        Args:
            sample: (7, 8) SI, rows of `hamr_dynamics.engine.ROWS`; hip angles and rates are used.
            base: (13,) SI: position m, quaternion xyzw, linear velocity in base_link m/s, angular velocity rad/s.
            command: +1 or -1, see `Task.directions`.
        """
        state = State.of_sample(sample, base)
        if self._start is None:
            self._start = place(state)
        return self._policy.targets(observe(self._policy.about["view"], state, np.array([float(command)]), self._start))[0]
