"""Compiled free runs of a machine: many lanes, each with parameters and effects of its own, under recorded drives.

One kernel holds every law of the library, each in a loop over lanes of its own behind a flag: all of them take two to seven times as
long as the machine alone, and a lane seldom uses more than three.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from types import ModuleType

import numpy as np

from . import emit
from .driver import HEADER
from .kernels import load_source
from .machine import Machine
from .machine_stages import arrays, parts

LANES = 8  # of a block: twice a vector of doubles, since one waits for itself; more share more laws that only some of them use

RUN = """

@jit
def run(drives, first, start, param, used, substeps, mean, own, seen, end):
    align_stack()
    work, total = aligned({size}, real), aligned({channels} * {lanes}, real)
    lanes = U({lanes})
    scale = real(1.0 / mean)
    for b in range(param.shape[0]):
        for i in range(start.shape[1]):
            work[U({state_at}) + U(i)] = start[b, i]
        for i in range(param.shape[1]):
            work[U({param_at}) + U(i)] = param[b, i]
        for row in range(seen.shape[2]):
            total[:] = 0.0
            for k in range(mean * substeps):
                for e in range(lanes):
                    at = first[b, e] + row * mean * substeps + k
                    for j in range({joints}):
                        work[U({drive_at}) + U(j) * lanes + U(e)] = drives[at, j]
{step}
                if k % substeps == 0:
                    for i in range({channels} * {lanes}):
                        total[U(i)] += scale * work[U({seen_at}) + U(i)]
            for c in range(own.shape[0]):
                for e in range({lanes}):
                    seen[b, e, row, c] = total[own[c] * {lanes} + e]
        for i in range(end.shape[1]):
            end[b, i] = work[U({state_at}) + U(i)]
"""


def source(machine: Machine) -> str:
    """Source of the module with `run`; machines of equal numbers have the same."""
    places, end = {}, 0
    for array, rows in arrays(machine).items():
        places[array] = places[f"new_{array}"] = end
        end += len(rows) * LANES
    functions, step = parts_source(machine, places, depth=16)
    head = HEADER.format(plant=f"{len(machine.joints)} joints", environment="machine", dtype="float64")
    return head + functions + RUN.format(
        size=end, lanes=LANES, joints=len(machine.joints), channels=len(machine.channels), step=step,
        **{f"{array}_at": places[array] for array in ("state", "param", "drive", "seen")},
    )  # fmt: skip


def parts_source(machine: Machine, places: dict[str, int], depth: int) -> tuple[str, str]:
    """Source of the parts of a step, and of their calls in order, the k-th law behind `used[b, k]`."""
    found = parts(machine)
    laws = [part for part in found if part.sizes]
    return emit.parts_source([(part, LANES) for part in found], laws=laws, work=places, flag="used[b, {}]", depth=depth)


@lru_cache(maxsize=16)
def module(machine: Machine) -> ModuleType:
    """The compiled module of a machine."""
    return load_source(f"machine_{len(machine.joints)}", source(machine))


@lru_cache(maxsize=16)
def _sizes(machine: Machine) -> tuple[np.ndarray, np.ndarray]:
    """(r,) parameter rows that are sizes of laws, and (r, laws) 1 where they are one of each; of reals, whose products are fast."""
    laws = [part.sizes for part in parts(machine) if part.sizes]
    found = np.zeros((len(machine.parameter_rows), len(laws)), np.float32)
    for law, rows in enumerate(laws):
        found[list(rows), law] = 1.0
    sizes = np.flatnonzero(found.any(1))
    return sizes, found[sizes]


def used_laws(machine: Machine, param: np.ndarray) -> np.ndarray:
    """(blocks, laws) which laws do something in some lane, of (blocks, rows * LANES) parameters; the kernel passes over the others."""
    sizes, of = _sizes(machine)
    some = (param.reshape(len(param), -1, LANES)[:, sizes] != 0).any(2)
    return some.astype(np.float32) @ of > 0


def simulate(
    machine: Machine, drives: np.ndarray, parameters: np.ndarray, *, step: float, substeps: int, mean: int = 1,
    first: np.ndarray | None = None, start: np.ndarray | None = None, samples: int | None = None,
    channels: Sequence[int] | None = None, every_law: bool = False,
) -> np.ndarray:  # fmt: skip
    """Free runs of K lanes; neighbours in a block take the time of all laws that any of them uses.

    Args:
        drives: (n, joints) drive at every step, U.
        parameters: (K, rows) as `machine.parameter_rows`; "step" is filled in.
        step: T. substeps: steps per sample. mean: samples averaged into one reading.
        first: (K,) index of the drive at which a lane starts; 0 if not given.
        start: (K, states) initial states as `machine.state_rows`; rest if not given.
        samples: readings wanted of each lane; as many as the drives last if not given.
        channels: those that are read, by number; all of `machine.channels` if not given.
        every_law: works out laws of size zero too; the readings are the same.

    Returns:
        (K, readings, channels).

    Raises:
        ValueError: the drives end before a run does.
    """
    if samples is None:
        samples = len(drives) // (substeps * mean)
    own = range(len(machine.channels)) if channels is None else channels
    return _run(machine, drives, parameters, step, substeps, mean, first, start, samples, own, every_law)[0]


def final_states(
    machine: Machine, drives: np.ndarray, parameters: np.ndarray, *, step: float, steps: int, first: np.ndarray, start: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """(K, states) after a number of steps of K lanes; arguments as for `simulate`.

    Internal states of a law of size zero mean nothing: they stay, or follow if another lane of the block uses the law.
    """
    return _run(machine, drives, parameters, step, 1, 1, first, start, steps, ())[1]


def _run(
    machine, drives, parameters, step, substeps, mean, first, start, samples, channels, every_law=False,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    lanes = len(parameters)
    blocks = -(-lanes // LANES)
    param = _blocks(np.asarray(parameters, float), blocks)
    row = machine.parameter_rows.index("step")
    param[:, row * LANES : (row + 1) * LANES] = step
    begin = np.zeros((lanes, len(machine.state_rows))) if start is None else np.asarray(start, float)
    at = np.zeros(blocks * LANES, np.int64)
    at[:lanes] = 0 if first is None else first
    if (last := int(at.max()) + samples * mean * substeps) > len(drives):  # the kernel would read on beyond them
        raise ValueError(f"The drives end after {len(drives)} steps, a run after {last}.")
    seen = np.empty((blocks, LANES, samples, len(channels)))
    end = np.empty((blocks, len(machine.state_rows) * LANES))
    used, own = used_laws(machine, param) | every_law, np.array(channels, np.int64)
    module(machine).run(
        np.ascontiguousarray(drives, float), at.reshape(blocks, LANES), _blocks(begin, blocks), param, used, substeps, mean, own, seen, end
    )
    ends = end.reshape(blocks, -1, LANES).transpose(0, 2, 1).reshape(blocks * LANES, -1)
    return seen.reshape(blocks * LANES, samples, len(channels))[:lanes], ends[:lanes]


def _blocks(x: np.ndarray, blocks: int) -> np.ndarray:
    """(lanes, rows) -> (blocks, rows * LANES), padded with the last lane."""
    full = np.concatenate([x, np.repeat(x[-1:], blocks * LANES - len(x), 0)])
    return np.ascontiguousarray(full.reshape(blocks, LANES, -1).transpose(0, 2, 1)).reshape(blocks, -1)
