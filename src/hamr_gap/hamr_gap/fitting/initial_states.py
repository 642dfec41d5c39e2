"""Starts of pieces as they may also have been: what another initial state would do to the readings counts for nothing.

Coordinates and rates at the start of a piece are measured with whatever is wrong with its sensor: the slope of a bent scale is off by
as much as the scale, and an oscillator carries that to the end of the piece, where it hides friction. So each piece's initial state is
solved for, linearly about the measured one, as in multiple shooting (Bock 1983), and projected out of everything that is compared.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from .model import Model

SMALL = 1e-3  # of what is usual: by how much starts are moved for a derivative
TELLING = 1e-6  # of the largest, below which a direction of the initial state does nothing


@dataclass(frozen=True, eq=False)
class InitialStates:
    """What initial states can do.

    Attributes:
        parts: first and last reading, and an orthonormal basis (readings * channels, r), in units of the noise, of each piece.
        sigma: (channels,) noise. known: (n, channels) where there is a reading.
        growth: (S, joints) how many times as far apart readings are in the last quarter of each piece as in its first, if a coordinate
            starts elsewhere: one for a machine without a spring, less for one that forgets, and far more for one that tips over.
    """

    parts: tuple[tuple[int, int, np.ndarray], ...]
    sigma: np.ndarray
    known: np.ndarray
    growth: np.ndarray

    @classmethod
    def about(cls, model: Model, row: np.ndarray, sigma: np.ndarray) -> InitialStates | None:
        """About a machine's motion; None for one that forgets how it started.

        Args:
            row: (rows,) lane parameters. sigma: (channels,) noise.
        """
        if not model.starts:
            return None
        known, n = np.isfinite(model.target), model.pieces.start.shape[1]
        moved = columns(model, row, model.run_rows(row[None])[0]) / sigma[:, None]
        grown = np.array([_grown(moved[a:b, :, : n // 2]) for a, b in model.pieces.parts])
        return cls(tuple((a, b, _basis(moved[a:b].reshape(-1, n))) for a, b in model.pieces.parts), sigma, known, grown)

    def beside(self, y: np.ndarray) -> np.ndarray:
        """Readings or differences of them, (..., n, channels), less what other initial states make of them; n may end early."""
        left = np.where(self.known[: y.shape[-2]], y, 0.0) / self.sigma
        with np.errstate(invalid="ignore"):  # a run that diverges is not finite, and stays so
            for first, stop, basis in self.parts:
                if stop <= y.shape[-2]:
                    part = left[..., first:stop, :]
                    flat = part.reshape(*y.shape[:-2], len(basis))
                    left[..., first:stop, :] = (flat - (flat @ basis) @ basis.T).reshape(part.shape)
        return np.where(self.known[: y.shape[-2]], left * self.sigma, y)


def _grown(moved: np.ndarray) -> np.ndarray:
    """(k,) rms of columns (m, channels, k) in their last quarter, over that in their first; one if they are nothing there."""
    quarter = len(moved) // 4
    begun, ended = (np.sqrt(np.mean(part**2, axis=(0, 1))) for part in (moved[:quarter], moved[len(moved) - quarter :]))
    return np.divide(ended, begun, out=np.ones_like(ended), where=begun > 0.0)


def columns(model: Model, row: np.ndarray, plain: np.ndarray) -> np.ndarray:
    """(n, channels, 2 joints) what readings `plain` change by as starts move by `SMALL` of what is usual; zero where nothing is read."""
    n, by = model.pieces.start.shape[1], SMALL * usual(model)
    moved = np.stack([_moved(model, k, by[k]).run_rows(row[None])[0] - plain for k in range(n)], -1)
    return np.where(np.isfinite(model.target)[..., None] & np.isfinite(moved), moved, 0.0)


def usual(model: Model) -> np.ndarray:
    """(2 joints,) usual coordinates and rates."""
    scales, joints = model.scales, model.pieces.start.shape[1] // 2
    return np.repeat([scales.coordinate, scales.coordinate / scales.time], joints)


def _moved(model: Model, which: int, by: float) -> Model:
    """The same with one coordinate or rate of every start moved."""
    start = model.pieces.start.copy()
    start[:, which] += by
    return begun(model, start)


def begun(model: Model, start: np.ndarray) -> Model:
    """The same with other starts, (S, 2 joints) coordinates and rates."""
    other = copy(model)
    other.pieces = replace(model.pieces, start=start)
    return other


def _basis(columns: np.ndarray) -> np.ndarray:
    """(m, r) orthonormal basis of what columns (m, n) span, each of them of its own size."""
    length = np.linalg.norm(columns, axis=0)
    left, size, _ = np.linalg.svd(columns / np.where(length > 0.0, length, 1.0), full_matrices=False)
    return left[:, size > TELLING * max(size.max(), 1e-300)]
