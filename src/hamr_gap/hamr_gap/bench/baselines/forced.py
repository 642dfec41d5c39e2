"""Runs in which the motion is prescribed: what a machine with some effects does next from each measured state.

The effects' own states (a lag, a bristle, creep) go on as they would along that motion.
"""

from __future__ import annotations

from functools import lru_cache
from types import ModuleType

import numpy as np

from hamr_dynamics.driver import HEADER
from hamr_dynamics.kernels import load_source
from hamr_dynamics.machine import Machine
from hamr_dynamics.machine_kernel import LANES, parts_source, used_laws
from hamr_dynamics.machine_stages import arrays

RUN = """

@jit
def run(drives, motion, param, used, substeps, mean, gained, seen):
    align_stack()
    work = aligned({size}, real)
    lanes = U({lanes})
    scale = real(1.0 / mean)
    for b in range(param.shape[0]):
        work[:] = real(0.0)
        for i in range(param.shape[1]):
            work[U({param_at}) + U(i)] = param[b, i]
        for s in range(gained.shape[1] * mean):
            row = s // mean
            for r in range(3 * {joints}):
                for e in range(lanes):
                    work[U({state_at}) + U(r) * lanes + U(e)] = motion[s, r]
            for k in range(s * substeps, (s + 1) * substeps):
                for j in range({joints}):
                    for e in range(lanes):
                        work[U({drive_at}) + U(j) * lanes + U(e)] = drives[k, j]
{step}
                if k == s * substeps:
                    for i in range({channels} * {lanes}):
                        seen[b, row, i] += scale * work[U({seen_at}) + U(i)]
            for j in range({joints}):
                for e in range(lanes):
                    at = U({joints} + j) * lanes + U(e)
                    gained[b, row, U(j) * lanes + U(e)] += work[U({state_at}) + at] - motion[s, {joints} + j]
"""


def forced(
    machine: Machine, drives: np.ndarray, motion: np.ndarray, rows: np.ndarray, *, step: float, substeps: int, mean: int
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Rates gained in each reading by K lanes, and what their sensors read.

    Args:
        drives: (n * substeps, joints) U at every step. motion: (n, 3 joints) coordinates, rates and accelerations at every sample, to
            which all lanes are set there.
        rows: (K, rows) as `machine.parameter_rows`; "step" is filled in.
        step: T. substeps: steps per sample. mean: samples in a reading.

    Returns:
        (K, readings, joints) Q/T that the machine itself would have gained, and (K, readings, channels) mean readings.
    """
    readings, blocks = len(motion) // mean, -(-len(rows) // LANES)
    padded = np.concatenate([rows, np.repeat(rows[-1:], blocks * LANES - len(rows), 0)])
    padded[:, machine.parameter_rows.index("step")] = step
    param = np.ascontiguousarray(padded.reshape(blocks, LANES, -1).transpose(0, 2, 1)).reshape(blocks, -1)
    gained, seen = (np.zeros((blocks, readings, count * LANES)) for count in (len(machine.joints), len(machine.channels)))
    _module(machine).run(
        np.ascontiguousarray(drives, float), np.ascontiguousarray(motion, float), param, used_laws(machine, param), substeps, mean,
        gained, seen,
    )  # fmt: skip
    by_lane = (x.reshape(blocks, readings, -1, LANES).transpose(0, 3, 1, 2) for x in (gained, seen))
    return tuple(x.reshape(blocks * LANES, readings, -1)[: len(rows)] for x in by_lane)


@lru_cache(maxsize=4)
def _module(machine: Machine) -> ModuleType:
    """The compiled module: the parts of a machine's step, each behind its flag, as in the kernel of free runs."""
    places, end = {}, 0
    for array, names in arrays(machine).items():
        places[array] = places[f"new_{array}"] = end
        end += len(names) * LANES
    joints = len(machine.joints)
    functions, step = parts_source(machine, places, depth=16)
    text = functions + RUN.format(
        size=end, lanes=LANES, joints=joints, channels=len(machine.channels), step=step,
        **{f"{array}_at": places[array] for array in ("state", "param", "drive", "seen")},
    )  # fmt: skip
    return load_source(f"forced_{joints}", HEADER.format(plant=f"{joints} joints", environment="forced", dtype="float64") + text)
