"""Which parts of a record are simulated each from a start of its own, and where they start.

A machine that forgets its start runs freely through a whole record. One that does not (no spring, or hardly a damper) would carry every
error to the end, and one that nothing drives has nothing but its start: they run in pieces, each started from what was measured there.
The states inside effects (a lag, a bristle) are those after a short run-in before the piece, at whose end coordinates and rates are set
to the measured ones again.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from hamr_description.errors import BagError
from hamr_dynamics.machine import Machine

from ..data.motion import coordinates, measured_by
from ..data.readings import noise_of
from ..data.record import Record

FORGETS = 0.1  # of a record: a machine whose slowest decay takes longer runs in pieces
SECONDS = 1.0  # of a piece of a machine that does not swing, at most
MANY = 32  # pieces there should be
FEW = 16  # of a machine that swings on and on: friction takes time to show
FEWEST = 40  # readings of a piece
RUN_IN = 0.2  # of a piece
ORDER = 3  # of the local polynomials
WIDTHS = (3, 5, 8, 12, 18, 27, 40, 60, 90, 135, 200)  # samples on either side
NEAR = 8  # samples on either side, within which a start must be measured
AGREE = 3.0  # standard deviations within which a wide window agrees with all narrower ones


@dataclass(frozen=True)
class Pieces:
    """Parts of a record, in readings.

    Attributes:
        first, stop: (S,) readings first to stop. lead: (S,) readings of run-in before them, the same for all, or none from rest.
        before, start: (S, 2 joints) coordinates and rates at the start of the run-in and of the piece.
        forgotten: whether a piece outlasts the memory of its start.
    """

    first: np.ndarray
    stop: np.ndarray
    lead: np.ndarray
    before: np.ndarray
    start: np.ndarray
    forgotten: bool

    def __len__(self) -> int:
        return len(self.first)

    @property
    def parts(self) -> list[tuple[int, int]]:
        """Readings first to stop of each."""
        return [(int(a), int(b)) for a, b in zip(self.first, self.stop, strict=True)]


@lru_cache(maxsize=8)  # models of one record, in coarse steps or fine, late or not, begin at the same starts
def pieces_of(machine: Machine, record: Record, mean: int, length: float = 0.0) -> Pieces | None:
    """The parts in which a machine runs through a record, or None for free runs from rest: one, or one of each stretch.

    Args:
        mean: samples averaged into one reading. length: T of a piece if the machine is not to choose.

    Raises:
        BagError: no stretch is long enough.
    """
    slow, _, _ = _memory(machine)
    forgotten = not length and slow <= FORGETS * record.span and record.driven.any()
    if forgotten and (record.rest or (len(record.stretches) == 1 and slow <= FORGETS**2 * record.span)):
        return None
    usual = record.span if forgotten else _usual(machine, record, mean)
    stretches = _long(record, mean)
    shortest = min(stop - start for start, stop in stretches) // mean
    readings = max(1, min(round((length or usual) / (record.step * mean)), int(shortest / (1.0 + RUN_IN))))
    lead = int(RUN_IN * min(readings, max(usual, telling(machine, record)) / (record.step * mean)))  # a long piece needs no longer one
    parts = [part for start, stop in stretches for part in _parts(-(-start // mean), stop // mean, readings, lead, record.rest)]
    first, stop, lead = np.array(parts, int).reshape(-1, 3).T
    still = record.rest & np.isin(first, [-(-start // mean) for start, _ in record.stretches])
    known = forgotten | still | (measured(machine, record, first * mean) & measured(machine, record, (first - lead) * mean))
    if known.any():
        first, stop, lead, still = first[known], stop[known], lead[known], still[known]
    before, start = (np.where(still[:, None], 0.0, moving(machine, record, at * mean)) for at in (first - lead, first))
    return Pieces(first, stop, lead, before, start, forgotten)


def _long(record: Record, mean: int) -> list[tuple[int, int]]:
    """Stretches of which a piece can be made: a clock that stutters at its start leaves some of a sample or two."""
    least = FEWEST * mean * (1.0 + RUN_IN)
    if not (found := [(start, stop) for start, stop in record.stretches if stop - start >= least]):
        most = max(stop - start for start, stop in record.stretches)
        raise BagError(f"At most {most} samples follow each other without a gap, and {least:.0f} are needed; record without gaps.")
    return found


def _usual(machine: Machine, record: Record, mean: int) -> float:
    """T of a piece of a machine that does not forget."""
    slow, swing, second = _memory(machine)
    least, many = FEWEST * mean * record.step, FEW if swing else MANY
    return float(np.clip(slow if swing else second, least, max(record.span / many, least)))


def telling(machine: Machine, record: Record) -> float:
    """T of a piece that is long enough to tell something, and short enough for many: four periods of what swings, else twice the
    slowest decay there is."""
    _, swing, second = _memory(machine)
    return min(4.0 * swing or second, record.span / MANY)


def _memory(machine: Machine) -> tuple[float, float, float]:
    """T of the slowest decay of the machine's own linear motion (infinite without a spring), of its longest period (zero if none),
    and of twice the slowest decay there is."""
    rest, n = machine.at_rest, len(machine.joints)
    mass, stiffness, damping = (_square(m, n) for m in (rest.mass, rest.stiffness, rest.damping))
    inverse = np.linalg.inv(mass)
    system = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ stiffness, -inverse @ damping]])
    roots = np.linalg.eigvals(system)
    decay, swing = -roots.real, np.abs(roots.imag)
    lost = 1e-9 * max(np.abs(roots).max(), 1e-300)
    slow = 1.0 / decay.min() if decay.min() > lost else np.inf
    swing = 2.0 * np.pi / swing[swing > lost].min() if swing.max() > lost else 0.0
    second = SECONDS / machine.to_si["T"]
    return slow, swing, min(2.0 / decay[decay > lost].min(), second) if decay.max() > lost else second


def _square(entries: tuple, n: int) -> np.ndarray:
    x = np.array(entries, float)
    return x.reshape(1, 1) if n == 1 else np.array([[x[0], x[1]], [x[1], x[2]]])


def _parts(begin: int, end: int, readings: int, lead: int, rest: bool) -> list[tuple[int, int, int]]:
    """(first, stop, run-in) of about equal parts of a stretch."""
    start = begin if rest else begin + lead
    edges = np.linspace(start, end, max(1, round((end - start) / readings)) + 1).astype(int)
    return [(a, b, 0 if a == begin else lead) for a, b in zip(edges[:-1], edges[1:], strict=True)]


def measured(machine: Machine, record: Record, samples: np.ndarray) -> np.ndarray:
    """(S,) whether the joints were read just before and just after some samples: a start within a gap would be a guess."""
    columns = [c for c, _ in measured_by(machine, record).values()]
    read = np.concatenate([[0], np.cumsum(np.isfinite(record.readings[:, columns]).all(1))])
    before = read[samples] - read[np.maximum(samples - NEAR, 0)]
    after = read[np.minimum(samples + NEAR, len(record))] - read[samples]
    return ((before >= ORDER) | (samples == 0)) & (after >= ORDER)


def moving(machine: Machine, record: Record, samples: np.ndarray) -> np.ndarray:
    """(S, 2 joints) coordinates and rates at some samples, from polynomials through the readings about them.

    Of windows of growing width the widest is taken that still agrees with every narrower one: noise wants wide ones, curves narrow ones.
    """
    n, q = len(machine.joints), coordinates(machine, record)
    found = np.zeros((len(samples), 2 * n))
    noise = noise_of(q)
    for j, (c, order) in measured_by(machine, record).items():  # where nobody looks, at rest is the best guess
        noise[j] = max(noise[j], record.rounding[c] if record.rounding and not order else 0.0)
        for i, at in enumerate(samples):
            start, stop = next((a, b) for a, b in record.stretches if a <= at < b or at == b == len(record))
            found[i, [j, n + j]] = _local(q[start:stop, j], at - start, noise[j], record.step)
    return found


def _local(y: np.ndarray, at: int, noise: float, step: float) -> np.ndarray:
    """Value and slope of samples y at an index."""
    best, low, high = np.zeros(2), np.full(2, -np.inf), np.full(2, np.inf)
    open_ = np.ones(2, bool)
    for width in WIDTHS:
        a, b = max(0, at - width), min(len(y), at + width + 1)
        known = np.isfinite(y[a:b])
        if known.sum() <= ORDER + 1:
            continue
        # about the middle of the window and in its units, so that powers stay apart
        basis = np.vander((np.arange(a, b)[known] - at) / width, ORDER + 1, increasing=True)
        scale = np.array([1.0, 1.0 / (width * step)])
        value = np.linalg.lstsq(basis, y[a:b][known], rcond=None)[0][:2] * scale
        sd = noise * np.sqrt(np.diag(np.linalg.inv(basis.T @ basis))[:2]) * scale
        low, high = np.maximum(low, value - AGREE * sd), np.minimum(high, value + AGREE * sd)
        open_ &= low <= high
        best = np.where(open_, value, best)
        if not open_.any():
            break
    return best
