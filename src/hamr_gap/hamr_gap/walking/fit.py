"""Least squares over what all segments share and over each one's own start, the starts eliminated segment by segment."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..parameters import Free
from .setting import ZEROS, Candidate, Setting, setting
from .starts import Replay, half_squares, restart

PROBE = 0.003  # of a parameter's prior, or of its scale where that is narrower

TRIALS = (1.0, 0.5, 0.2)
DAMPINGS = (0.0, 0.03, 1e3)  # of how starts follow: the last leaves them where they are
BAD = 3.0  # times the usual cost of a segment, above which it counts less: contact may have gone another way
TOLERANCE = 0.01  # relative decrease of cost at which a fit ends


@dataclass(frozen=True)
class Fit:
    """Result of a fit.

    Attributes:
        free, x: what is shared, in scales. effects. change: (s, 28) starts. residual: (s, readings + 28). cost: half squares with priors.
        hessian: (P, P) of the shared numbers with priors, the starts eliminated.
        moved: by how much another fit from starts of its own moved x, (P,) or 0 where there was none.
    """

    free: tuple[Free, ...]
    x: np.ndarray
    effects: tuple[Candidate, ...]
    change: np.ndarray
    residual: np.ndarray
    cost: float
    hessian: np.ndarray
    moved: np.ndarray | float = 0.0

    @property
    def model(self) -> Setting:
        """As a model."""
        return setting(self.free, self.x, self.effects)


class Eliminated:
    """Slopes of segments with the starts eliminated: what is left of readings once each start has adapted."""

    def __init__(self, slopes: np.ndarray, residual: np.ndarray, weight: np.ndarray) -> None:
        """Args: slopes (s, c, 28), residual (s, c), weight (s,)."""
        self._slopes, self._residual, self.weight = slopes, residual, weight
        self._gram = np.einsum("sci,scj->sij", slopes, slopes, optimize=True)
        self._inverse = np.linalg.inv(self._gram)
        self._pull = np.einsum("sci,sc->si", slopes, residual, optimize=True)

    def normal(self, columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(P, P) and (P,) normal equations of columns (s, c, P)."""
        across = np.matmul(self._slopes.transpose(0, 2, 1), columns)
        solved = np.matmul(self._inverse, across) * self.weight[:, None, None]
        weighted = (columns * self.weight[:, None, None]).reshape(-1, columns.shape[2])
        flat = columns.reshape(-1, columns.shape[2])
        hessian = flat.T @ weighted - across.reshape(-1, across.shape[2]).T @ solved.reshape(-1, across.shape[2])
        gradient = weighted.T @ self._residual.ravel() - np.einsum("sip,si->p", solved, self._pull)
        return hessian, gradient

    def starts(self, columns: np.ndarray, step: np.ndarray, damping: float) -> np.ndarray:
        """(s, 28) changes of the starts that go with a step (P,) of the columns."""
        pull = np.matmul(self._slopes.transpose(0, 2, 1), (columns @ step)[..., None])
        diagonal = np.einsum("sii->si", self._gram)[:, :, None] * np.eye(self._gram.shape[1])
        return -np.linalg.solve(self._gram + damping * diagonal, pull)[..., 0]


def weights(residual: np.ndarray) -> np.ndarray:
    """(s,) of segments: one, less for those that fit far worse than most."""
    cost = half_squares(residual)
    return np.minimum(1.0, BAD * np.median(cost) / cost)


def columns(
    replay: Replay, free: Sequence[Free], x: np.ndarray, effects: Sequence[Candidate], change: np.ndarray, residual: np.ndarray
) -> np.ndarray:
    """(s, readings, P) derivatives of what is predicted by the free numbers."""
    step = PROBE * np.minimum([f.sd for f in free], 1.0)
    step = np.where(x + step > [f.high for f in free], -step, step)
    shown = [k for k, f in enumerate(free) if not f.row.startswith("zero.")]
    probed = replay.each(change, [setting(free, x + step[k] * (np.arange(len(free)) == k), effects) for k in shown])
    found = np.empty((*residual.shape, len(free)))
    found[..., shown] = ((residual - probed) / step[shown, None, None]).transpose(1, 2, 0)
    zeros = replay.zeros
    for k, f in enumerate(free):
        if f.row.startswith("zero."):  # these are linear, and simulated by nobody
            found[..., k] = f.scale * zeros[..., ZEROS.index(f.row.removeprefix("zero."))]
    return found


def fit(replay: Replay, free: Sequence[Free], x0: np.ndarray, effects: Sequence[Candidate], change: np.ndarray, *, rounds: int = 8) -> Fit:
    """Fits shared numbers (P,) from x0 strictly inside their bounds, and starts (s, 28) from `change`."""
    low, high, center, sd = (np.array([getattr(f, name) for f in free]) for name in ("low", "high", "center", "sd"))
    x = np.clip(x0, low, high)
    residual = replay.each(change, [setting(free, x, effects)])[0]
    weight = weights(residual)

    def prior_cost(at) -> float:
        return 0.5 * float(np.sum(((at - center) / sd) ** 2))

    def total(r, at) -> float:
        return float(weight @ np.minimum(half_squares(r), 1e12)) + prior_cost(at)

    cost = total(residual, x)
    prior = np.diag(sd**-2.0)
    hessian = prior
    for _ in range(rounds):
        slopes = replay.slopes(change, residual, setting(free, x, effects))
        b = columns(replay, free, x, effects, change, residual)
        linear = Eliminated(slopes, residual, weight)
        hessian, gradient = linear.normal(b)
        hessian, gradient = hessian + prior, gradient - (x - center) / sd**2
        step = bounded(hessian, gradient, x, low, high)
        ways = [(np.clip(x + share * step, low, high), damping) for share in TRIALS for damping in DAMPINGS]
        starts = np.concatenate([change + linear.starts(b, at - x, damping) for at, damping in ways])
        s, m = len(replay), len(ways)
        models = [setting(free, at, effects) for at, _ in ways]
        left = replay.residual(starts, models, np.repeat(np.arange(m), s), np.tile(np.arange(s), m)).reshape(m, s, -1)
        starts = starts.reshape(m, s, -1)
        # each segment takes the damping that suits it
        each = half_squares(left.reshape(m * s, -1)).reshape(len(TRIALS), len(DAMPINGS), s)
        suits = np.argmin(each, 1)  # trials, s
        costs = [
            float(weight @ np.minimum(e.min(0), 1e12)) + prior_cost(at) for e, (at, _) in zip(each, ways[:: len(DAMPINGS)], strict=True)
        ]
        best = int(np.argmin(costs))
        at = ways[best * len(DAMPINGS)][0]
        pick = best * len(DAMPINGS) + suits[best], np.arange(s)
        new = restart(replay, setting(free, at, effects), starts[pick], left[pick], 1)
        fresh = float(weight @ new.cost) + prior_cost(at)
        if not fresh < cost:
            break
        gained = cost - fresh
        x, change, residual = at, new.change, new.residual
        weight = weights(residual)
        cost = total(residual, x)
        if gained < TOLERANCE * cost:
            break
    return Fit(tuple(free), x, tuple(effects), change, residual, cost, hessian)


def bounded(hessian: np.ndarray, gradient: np.ndarray, x: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """(P,) Newton step that does not push further what already sits on a bound."""
    held = np.zeros(len(x), bool)
    for _ in range(len(x) + 1):
        free = ~held
        step = np.zeros(len(x))
        scale = 1.0 / np.sqrt(np.diag(hessian)[free])
        scaled = hessian[np.ix_(free, free)] * scale[:, None] * scale
        step[free] = scale * np.linalg.solve(scaled + 1e-12 * np.eye(len(scaled)), scale * gradient[free])
        pushing = ((x <= low) & (step < 0)) | ((x >= high) & (step > 0))
        if not (pushing & ~held).any():
            break
        held |= pushing
    return step
