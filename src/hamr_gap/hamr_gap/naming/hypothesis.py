"""Hypotheses about what is missing: first steps that are simulated, fits for good, and what each leaves on readings not fitted."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from ..fitting.continued import continued
from ..fitting.corrected import Corrected
from ..fitting.fit import Fit, fit
from ..fitting.parameters import Candidate, Free, effect_parameters
from ..fitting.race import raced
from ..fitting.threads import at_once
from ..fitting.weighed import Weighed
from .screen import BATCH, Screen, Solution

#: Shares of a linear solution that are simulated: of its re-tune, which may lead astray where the base is far off, and of its effects.
STEPS = ((1.0, 1.0), (0.4, 0.4), (0.15, 0.15), (0.0, 0.15))
SEEN = 0.05  # of its response, that a size with a threshold must show in a solution, or it is off
BLOCKS = 24  # of the judged readings, for spread
FEWEST = 6  # pieces that are blocks of their own, and blocks there must be
MOVES = 3.0  # standard deviations of the noise, by which a sensor's readings vary within a block that tells something


@dataclass(frozen=True)
class Start:
    """Where a fit may begin.

    Attributes:
        effects. free, x: parameters and values. cost: half sum of squares on the fitted readings there, priors left out.
    """

    effects: tuple[Candidate, ...]
    free: tuple[Free, ...]
    x: np.ndarray
    cost: float


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """Some effects (none: a re-tune alone), fitted.

    Attributes:
        effects. fit: on the fitted readings.
        left: mean square of the judged readings' residual, in units of the noise. blocks: (b,) the same for each block of readings.
    """

    effects: tuple[Candidate, ...]
    fit: Fit
    left: float
    blocks: np.ndarray

    @property
    def names(self) -> frozenset:
        """Families and places."""
        return frozenset(c.name for c in self.effects)

    @property
    def parameters(self) -> int:
        """Number of sizes and shapes."""
        return sum(len(c.rows(shape=shape)) for c in self.effects for shape in (False, True))


def residual(weighed: Weighed, found: Fit) -> np.ndarray:
    """(n, channels) in units of the noise."""
    return weighed.left(found.reading)


def judge(weighed: Weighed, judged: np.ndarray, effects: Sequence[Candidate], found: Fit) -> Hypothesis:
    """A hypothesis from its fit."""
    return Hypothesis(tuple(effects), found, *left_of(weighed, judged, found.reading))


def left_of(weighed: Weighed, judged: np.ndarray, reading: np.ndarray) -> tuple[float, np.ndarray]:
    """Mean square, in units of the noise, by which readings (n, channels) miss the judged ones: of all, and (b,) of each block in which
    something moves. What stands still tells no law of motion from another, and a run that diverges misses by any amount."""
    square = np.where(judged, np.where(np.isfinite(reading), weighed.left(reading) ** 2, np.inf), np.nan)
    rows = np.flatnonzero(judged.any(1))
    blocks = blocks_of(weighed, rows)
    moves = [bool((np.nanstd(weighed.model.target[part], axis=0) > MOVES * weighed.sigma).any()) for part in blocks]
    told = [part for part, moving in zip(blocks, moves, strict=True) if moving] if sum(moves) >= FEWEST else blocks
    return float(np.nanmean(square[rows])), np.array([np.nanmean(square[part]) for part in told])


def blocks_of(weighed: Weighed, rows: np.ndarray) -> list[np.ndarray]:
    """Judged readings in blocks: what starts anew together belongs together, where there are enough of them."""
    own = np.searchsorted(weighed.model.starts, rows, side="right")
    each = [rows[own == k] for k in np.unique(own)]
    return each if len(each) >= FEWEST else np.array_split(rows, min(BLOCKS, len(rows)))


def starts(weighed: Weighed, base: Fit, seen: Screen, wanted: Sequence[tuple[Sequence[Candidate], Solution]]) -> list[Start]:
    """For each set of effects with its linear solution, the best of a few steps towards it, simulated."""
    prepared = []
    known = {f.row for f in base.free}
    for effects, solution in wanted:
        free = (*base.free, *(f for f in effect_parameters(effects, weighed.model.scales) if f.row not in known))
        for shares in STEPS:
            prepared.append((tuple(effects), free, _at(free, base, seen, solution, *shares)))
    weighed = weighed.fitted
    model = weighed.model
    runs = Corrected(weighed, base.free, base.x, base.run[: weighed.until])
    target = weighed.vector(model.target)
    sensors = weighed.sensor_columns(weighed.moved(base.run, base.sensors.shift))
    doubt = weighed.doubt(target - weighed.vector(base.reading))
    solver = np.linalg.inv(sensors.T @ sensors + np.diag(doubt * weighed.sensor_precision)) @ sensors.T

    def costs_of(part: Sequence[tuple]) -> list[float]:
        near = runs.near_rows(np.concatenate([model.rows(free, x) for _, free, x in part]))
        left = target - weighed.vector(base.sensors.read(near, model.reading_step, model.starts))
        return (0.5 * np.sum(left * (left - (left @ solver.T) @ sensors.T), axis=1)).tolist()  # sensors follow, as far as one believes

    found: dict[int, Start] = {}
    costs = chain.from_iterable(at_once(costs_of, (prepared[at : at + BATCH] for at in range(0, len(prepared), BATCH))))
    for k, ((effects, free, x), cost) in enumerate(zip(prepared, costs, strict=True)):
        which = k // len(STEPS)
        if np.isfinite(cost) and (which not in found or cost < found[which].cost):
            found[which] = Start(effects, free, x, cost)
    return list(found.values())


def _at(
    free: Sequence[Free], base: Fit, seen: Screen, solution: Solution, retune: float, share: float,
) -> np.ndarray:  # fmt: skip
    """(P,) shares of the way to a linear solution, for its re-tune and for its effects; sizes inside their bounds, shapes as screened."""
    n = len(base.free)
    x = dict(zip((f.row for f in base.free), base.x + retune * solution.value[:n], strict=True))
    old = dict(zip((f.row for f in base.free), base.x, strict=True))
    for c, v in zip(solution.chosen, solution.value[seen.fixed :], strict=True):
        column = seen.columns[c]
        step = seen.size_of(c, share * v) or 0.02 * share * column.parameter.typical
        if column.parameter.screen and v < SEEN:
            step = 0.0
        x[column.row] = old.get(column.row, 0.0) + step
        x |= {row: s for row, s in column.shapes if row not in old}
    low, high = np.array([f.low for f in free]), np.array([f.high for f in free])
    return np.clip(np.array([x.get(f.row, f.center) for f in free]), low, high)


def refine(weighed: Weighed, judged: np.ndarray, start: Start) -> Hypothesis:
    """Fits a set of effects for good."""
    return judge(weighed, judged, start.effects, fit(weighed, start.free, start.x))


def settled(weighed: Weighed, judged: np.ndarray, h: Hypothesis) -> Hypothesis:
    """A hypothesis fitted on in fine steps until none is worth anything beside the noise, as an interval about it needs; itself where
    parameters are pinned."""
    if any(f.low == f.high for f in h.fit.free):
        return h
    return judge(weighed, judged, h.effects, fit(replace(weighed, coarse=None), h.fit.free, h.fit.x, tolerance=0.0))


def refined(weighed: Weighed, judged: np.ndarray, found: Iterable[Start], known: Iterable[Hypothesis] = ()) -> list[Hypothesis]:
    """Fits several sets for good, those that come nowhere near the best, or others that are known, only until steps gain little.

    Where pieces were doubled, all of them, and from shorter pieces too.
    """
    found = list(found)
    fits = raced(weighed, ((start.free, start.x) for start in found), [h.fit for h in known])
    if weighed.shorter:
        led = at_once(lambda start: continued(weighed, start.free, start.x), found)
        fits = [min(pair, key=lambda f: f.cost) for pair in zip(fits, led, strict=True)]
    return [judge(weighed, judged, start.effects, f) for start, f in zip(found, fits, strict=True)]
