"""Forward stepwise selection by BIC: the effect that lowers it most is added, until none does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...fitting.parameters import Candidate
from ...fitting.weighed import Weighed
from ...judging.colour import correlation_time
from ...naming.candidates import candidates
from ...naming.hypothesis import Hypothesis, Start, refine, residual, starts
from ...naming.prepare import Prepared
from ...naming.screen import screen
from .result import Path, Step, falling

FITTED = 10  # names of a round that are fitted for good
SHAPES = 2  # sets of shapes of each candidate that are simulated
MOST = 4  # effects


def stepwise(prepared: Prepared) -> Path:
    """Rounds of one effect more each; the level of a round is by how much BIC falls."""
    weighed, best = prepared.weighed, prepared.base
    everything = candidates(weighed.model.machine, weighed.model.record)
    gains, found = [], []
    while len(found) < MOST:
        others = [c for c in everything if all(c.effect != e.effect for e in best.effects)]
        tried = [refine(weighed, prepared.judged, start) for start in _starts(weighed, best, others)]
        if not tried:
            break
        independent = _independent(weighed, min(tried, key=lambda h: _left(weighed, h)))
        least = min(tried, key=lambda h: bic(weighed, h, independent))
        gains.append(bic(weighed, best, independent) - bic(weighed, least, independent))
        best = replace(least, effects=(*best.effects, *least.effects))
        found.append(best)
        if gains[-1] <= 0.0:
            break
    return Path([Step(level, h) for level, h in zip(falling(gains), found, strict=True)], threshold=0.0)


def bic(weighed: Weighed, h: Hypothesis, independent: float) -> float:
    """Bayesian information criterion on the fitted readings, of which so many are independent."""
    return float(independent * np.log(_left(weighed, h)) + len(h.fit.free) * np.log(independent))


def _independent(weighed: Weighed, h: Hypothesis) -> float:
    """Readings that count as independent where a model leaves residuals that are not white."""
    return max(2.0, weighed.chosen.sum() / correlation_time(residual(weighed, h.fit)[weighed.chosen.any(1)]))


def _left(weighed: Weighed, h: Hypothesis) -> float:
    """Mean square on the fitted readings."""
    return float(np.mean(weighed.vector(weighed.model.target - h.fit.reading) ** 2))


def _starts(weighed: Weighed, about: Hypothesis, wanted: Sequence[Candidate]) -> list[Start]:
    """Where to begin, of the names that look best in the linear picture."""
    seen = screen(weighed, about.fit, wanted, amplitude=float(np.sqrt(_left(weighed, about))))
    found = starts(weighed, about.fit, seen, [((c,), s) for c in wanted for s in seen.best(c, SHAPES)])
    best: dict[tuple, Start] = {}
    for start in sorted(found, key=lambda s: s.cost):
        best.setdefault(start.effects[0].name, start)
    return list(best.values())[:FITTED]
