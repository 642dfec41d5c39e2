"""Least squares over what all segments share and over each one's own start."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..fitting.parameters import Free
from .eliminate import Eliminated, bounded
from .replay import Replay, chord, half_squares
from .setting import ZEROS, Candidate, Setting, setting

PROBE = 0.1  # of a parameter's prior, or of its scale where that is narrower: contacts bend what moves, and a chord leads further
MARQUARDT, FACTORS = 0.01, (0.1, 1.0, 10.0)  # share of its curvature that is added to each direction at first, and what is tried of it
DAMPINGS = (0.0, 0.03, 0.3, 1e3)  # likewise of the starts, each with what suits it: the last leaves them where they are
BAD = 3.0  # times the usual cost of a segment, above which it counts less: contact may have gone another way
SETTLING = 2  # rounds in which starts settle before a step is judged: contacts bend what they follow, and good steps look wrong before
TOLERANCE = 0.01  # relative decrease of cost at which a fit ends
ROUNDS = 10
SETTLED = 0.98  # share of another fit's cost, above which that costs hardly more


@dataclass(frozen=True)
class Fit:
    """Result of a fit.

    Attributes:
        free, x: what is shared, in scales. effects. change: (s, 28) starts. residual: (s, readings + 28).
        cost: half squares, limited where a segment is far worse than most.
        hessian: (P, P) of the shared numbers with priors, the starts eliminated; what is left counts as noise.
        away: how far off other fits end that cost hardly more (`kept`); 0 where there was none.
    """

    free: tuple[Free, ...]
    x: np.ndarray
    effects: tuple[Candidate, ...]
    change: np.ndarray
    residual: np.ndarray
    cost: float
    hessian: np.ndarray
    away: float = 0.0

    @property
    def model(self) -> Setting:
        """As a model."""
        return setting(self.free, self.x, self.effects)

    def apart(self, other: Fit) -> float:
        """How far off another fit ends: rms in standard deviations, over what is shared."""
        off = other.x - self.x
        return float(np.sqrt(off @ self.hessian @ off / len(off)))


def kept(*fits: Fit) -> Fit:
    """Of fits of the same numbers the one that costs least, with how far off those end that cost hardly more.

    Contact has many minima: where a fit ends depends on where it begins, and nothing says which of two that cost the same is right.
    """
    best = min(fits, key=lambda found: found.cost)
    near = [best, *(found for found in fits if SETTLED * found.cost < best.cost)]
    return replace(best, away=max(max(found.away, best.apart(found)) for found in near))


def weights(residual: np.ndarray) -> np.ndarray:
    """(s,) of segments: what a model leaves counts as noise, so that priors hold while it is far off; the worst segments count less.

    One that diverges counts nothing.
    """
    cost = half_squares(residual)
    usual = float(np.median(cost))
    return np.minimum(1.0, BAD * usual / cost) / max(1.0, 2.0 * usual / residual.shape[1])


def limited(residual: np.ndarray) -> float:
    """Half squares of residuals (s, c), limited where a segment is far worse than most."""
    each = half_squares(residual)
    return float(np.minimum(each, BAD * np.median(each)).sum())


def columns(
    replay: Replay, free: Sequence[Free], x: np.ndarray, effects: Sequence[Candidate], change: np.ndarray, residual: np.ndarray,
    known: np.ndarray | None = None,
) -> np.ndarray:  # fmt: skip
    """(s, readings, P) derivatives of what is predicted by the free numbers; `known` (s, readings, K): those of the first K."""
    first = 0 if known is None else known.shape[2]
    step = PROBE * np.minimum([f.sd for f in free], 1.0)
    step = np.where(x + step > [f.high for f in free], -step, step)
    shown = [k for k, f in enumerate(free) if k >= first and not f.row.startswith("zero.")]
    probed = replay.each(change, [setting(free, x + step[k] * (np.arange(len(free)) == k), effects) for k in shown])
    found = np.empty((*residual.shape, len(free)))
    found[..., shown] = (chord(residual, probed) / step[shown, None, None]).transpose(1, 2, 0)
    if known is not None:
        found[..., :first] = known
    zeros = replay.zeros
    for k, f in enumerate(free):
        if f.row.startswith("zero."):  # these are linear, and simulated by nobody
            found[..., k] = f.scale * zeros[..., ZEROS.index(f.row.removeprefix("zero."))]
    return found


def fit(
    replay: Replay, free: Sequence[Free], x0: np.ndarray, effects: Sequence[Candidate], change: np.ndarray,
    known: np.ndarray | None = None, *, slopes: np.ndarray | None = None, rounds: int = ROUNDS,
) -> Fit:  # fmt: skip
    """Fits shared numbers (P,) from x0 strictly inside their bounds, and starts (s, 28) from `change`.

    Args:
        known: (s, readings, K) derivatives by the first K numbers, taken near by: a chord serves as well as a tangent, and costs nothing.
        slopes: (s, readings, 28) likewise by the starts, for a brief look; else they are taken anew each round.
        rounds: at most.
    """
    low, high, center, sd = (np.array([getattr(f, name) for f in free]) for name in ("low", "high", "center", "sd"))
    x = np.clip(x0, low, high)
    residual = replay.each(change, [setting(free, x, effects)])[0]
    weight = weights(residual)
    prior = np.diag(sd**-2.0)

    def cost_of(each: np.ndarray, at: np.ndarray) -> float:
        return float(weight @ np.minimum(each, 1e12)) + 0.5 * float(np.sum(((at - center) / sd) ** 2))

    hessian, damping = prior, MARQUARDT
    for _ in range(rounds):
        cost = cost_of(half_squares(residual), x)
        along = replay.slopes(change, residual, setting(free, x, effects)) if slopes is None else slopes
        own = columns(replay, free, x, effects, change, residual, known)
        linear = Eliminated(along)
        hessian, gradient = linear.normal(own, residual, weight)
        hessian, gradient = hessian + prior, gradient - (x - center) / sd**2
        dampings = [damping * factor for factor in FACTORS]
        steps = [bounded(hessian + d * np.diag(np.diag(hessian)), gradient, x, low, high) for d in dampings]
        tries = [np.clip(x + step, low, high) for step in steps]
        models = [setting(free, at, effects) for at in tries]
        left, starts = _followed(replay, linear, models, [residual - own @ (at - x) for at in tries], change)
        costs = [cost_of(half_squares(r), at) for r, at in zip(left, tries, strict=True)]
        best = int(np.argmin(costs))
        if not costs[best] < cost:
            damping *= FACTORS[-1] ** 2
            continue
        gained, damping = cost - costs[best], dampings[best]
        x, change, residual = tries[best], starts[best], left[best]
        weight = weights(residual)
        if gained < TOLERANCE * cost:
            break
    return Fit(tuple(free), x, tuple(effects), change, residual, limited(residual), hessian)


def _followed(
    replay: Replay, linear: Eliminated, models: Sequence[Setting], foreseen: Sequence[np.ndarray], change: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Residuals (m, s, c) and starts (m, s, 28) under models, whose residuals (s, c) are foreseen for starts that stay.

    Starts follow what is foreseen, and settle by what is left then.
    """
    starts = np.broadcast_to(change, (len(models), *change.shape))
    for _ in range(1 + SETTLING):
        ways = starts[:, None] + np.stack([linear.starts(each, DAMPINGS) for each in foreseen])
        foreseen, starts = replay.suited(models, ways)
    return foreseen, starts
