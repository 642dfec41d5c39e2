"""Starts of long pieces, moved to where a model leaves least: what a run makes of its start is a straight line about that only nearby."""

from __future__ import annotations

import numpy as np

from .initial_states import SMALL, begun, columns, usual
from .model import Model
from .sensors import Sensors

STEPS = 8


def settled(model: Model, row: np.ndarray, sigma: np.ndarray, sensors: Sensors) -> Model:
    """The same, each piece begun where it leaves least: Gauss-Newton steps over its initial state, shortened where they do not help.

    Args:
        row: (rows,) lane parameters. sigma: (channels,) noise. sensors: that read the runs.
    """
    if not model.starts:
        return model
    share = np.ones((len(model.pieces), 1))
    left, squares = _left(model, row, sigma, sensors)
    for _ in range(STEPS):
        tried = begun(model, model.pieces.start + share * _step(model, row, left / sigma, sigma))
        left_there, squares_there = _left(tried, row, sigma, sensors)
        less = squares_there < squares
        model = begun(model, np.where(less[:, None], tried.pieces.start, model.pieces.start))
        for (a, b), taken in zip(model.pieces.parts, less, strict=True):
            left[a:b] = left_there[a:b] if taken else left[a:b]
        squares, share = np.minimum(squares, squares_there), np.where(less[:, None], 1.0, 0.5 * share)
    return model


def _left(model: Model, row: np.ndarray, sigma: np.ndarray, sensors: Sensors) -> tuple[np.ndarray, np.ndarray]:
    """(n, channels) of what a run leaves, zero where nothing is read, and (S,) sums of its squares in units of the noise."""
    run = sensors.read(model.run_rows(row[None])[0], model.reading_step, model.starts)
    left = np.where(np.isfinite(model.target), model.target - run, 0.0)
    sums = np.array([np.sum((left[a:b] / sigma) ** 2) for a, b in model.pieces.parts])
    return left, np.where(np.isfinite(sums), sums, np.inf)


def _step(model: Model, row: np.ndarray, left: np.ndarray, sigma: np.ndarray) -> np.ndarray:
    """(S, 2 joints) by which starts move, to first order, to leave least of (n, channels) in units of the noise."""
    moved = columns(model, row, model.run_rows(row[None])[0]) / sigma[:, None]
    n = moved.shape[-1]
    found = [np.linalg.lstsq(moved[a:b].reshape(-1, n), left[a:b].ravel(), rcond=None)[0] for a, b in model.pieces.parts]
    return np.array(found) * SMALL * usual(model)
