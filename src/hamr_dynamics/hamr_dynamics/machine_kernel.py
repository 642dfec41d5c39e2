"""Compiled free runs of a machine: many lanes, each with parameters and effects of its own, under recorded drives."""

from __future__ import annotations

from functools import lru_cache
from types import ModuleType

import numpy as np

from .driver import HEADER
from .emit import loop_body
from .kernels import load_source
from .machine import Machine, step_stage

LANES = 16

RUN = """

@jit
def run(drives, first, start, param, substeps, mean, every, seen, end):
    align_stack()
    work = aligned({size}, real)
    lanes = U({lanes})
    scale = real(1.0 / mean)
    for b in range(param.shape[0]):
        work[{state}] = start[b]
        work[{param}] = param[b]
        seen[b] = ZERO
        for k in range(seen.shape[1] * mean * substeps):
            for e in range(lanes):
                at = first[b, e] + k
                for j in range({joints}):
                    work[U({drive_at}) + U(j) * lanes + U(e)] = drives[at, j]
{step}
            sample = k // substeps
            if k % substeps == 0 and sample % every < mean:
                row = sample // every
                if row < seen.shape[1]:
                    for i in range({channels} * {lanes}):
                        seen[b, row, i] += scale * work[U({seen_at}) + U(i)]
        end[b] = work[{state}]
"""


def source(machine: Machine) -> str:
    """Source of the module with `run`."""
    stage = step_stage(machine)
    sizes = {"state": machine.state_rows, "drive": machine.joints, "param": machine.parameter_rows, "seen": machine.channels}
    places, end = {}, 0
    for array, rows in sizes.items():
        places[array] = end
        end += len(rows) * LANES
    places["new_state"] = places["state"]
    spans = {array: f"{places[array]}:{places[array] + len(rows) * LANES}" for array, rows in sizes.items()}
    body = loop_body(stage, LANES, work=places, indent=12).rstrip()
    return HEADER.format(plant=machine.name, environment="machine", dtype="float64") + RUN.format(
        size=end, lanes=LANES, state=spans["state"], param=spans["param"], joints=len(machine.joints), channels=len(machine.channels),
        drive_at=places["drive"], seen_at=places["seen"], step=body,
    )  # fmt: skip


@lru_cache(maxsize=16)
def module(machine: Machine) -> ModuleType:
    """The compiled module of a machine."""
    return load_source(f"machine_{machine.name}", source(machine))


def simulate(
    machine: Machine, drives: np.ndarray, parameters: np.ndarray, *, step: float, substeps: int, mean: int = 1,
    first: np.ndarray | None = None, start: np.ndarray | None = None, samples: int | None = None,
) -> np.ndarray:  # fmt: skip
    """Free runs of K lanes.

    Args:
        drives: (n, joints) drive at every step, U.
        parameters: (K, rows) as `machine.parameter_rows`; "step" is filled in.
        step: T. substeps: steps per sample. mean: samples averaged into one reading.
        first: (K,) index of the drive at which a lane starts; 0 if not given.
        start: (K, states) initial states as `machine.state_rows`; rest if not given.
        samples: readings wanted of each lane; as many as the drives last if not given.

    Returns:
        (K, readings, channels).
    """
    if samples is None:
        samples = len(drives) // (substeps * mean)
    return _run(machine, drives, parameters, step, substeps, mean, first, start, samples)[0]


def final_states(
    machine: Machine, drives: np.ndarray, parameters: np.ndarray, *, step: float, steps: int, first: np.ndarray, start: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """(K, states) after a number of steps of K lanes; arguments as for `simulate`."""
    return _run(machine, drives, parameters, step, 1, 1, first, start, steps)[1]


def _run(machine, drives, parameters, step, substeps, mean, first, start, samples) -> tuple[np.ndarray, np.ndarray]:
    lanes = len(parameters)
    blocks = -(-lanes // LANES)
    param = _blocks(np.asarray(parameters, float), blocks)
    row = machine.parameter_rows.index("step")
    param[:, row * LANES : (row + 1) * LANES] = step
    begin = np.zeros((lanes, len(machine.state_rows))) if start is None else np.asarray(start, float)
    at = np.zeros(blocks * LANES, np.int64)
    at[:lanes] = 0 if first is None else first
    seen = np.empty((blocks, samples, len(machine.channels) * LANES))
    end = np.empty((blocks, len(machine.state_rows) * LANES))
    module(machine).run(
        np.ascontiguousarray(drives, float), at.reshape(blocks, LANES), _blocks(begin, blocks), param, substeps, mean, mean, seen, end
    )
    return _lanes(seen, samples, len(machine.channels), lanes), _lanes(end, 1, len(machine.state_rows), lanes)[:, 0]


def _lanes(x: np.ndarray, samples: int, width: int, lanes: int) -> np.ndarray:
    """(blocks, samples * width * LANES) -> (lanes, samples, width)."""
    by_lane = x.reshape(len(x), samples, width, LANES).transpose(0, 3, 1, 2)
    return by_lane.reshape(len(x) * LANES, samples, width)[:lanes]


def _blocks(x: np.ndarray, blocks: int) -> np.ndarray:
    """(lanes, rows) -> (blocks, rows * LANES), padded with the first lane."""
    full = np.concatenate([x, np.repeat(x[:1], blocks * LANES - len(x), 0)])
    return np.ascontiguousarray(full.reshape(blocks, LANES, -1).transpose(0, 2, 1)).reshape(blocks, -1)
