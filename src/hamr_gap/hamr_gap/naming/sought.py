"""Fits of sets of effects, from where short pieces of the record lead as well, where no set explains what there is.

What sticks, plays or hits a stop makes the cost of a free run rough: a run that lets go at another time than the machine did is lost
from there on, and fits rest in the minima that this makes. A short run from a measured start has no time for that (multiple shooting,
Bock 1983), so fits of these end near the right numbers, from which a free run is fitted for good.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from ..fitting.fit import explains, fit
from ..fitting.race import raced
from ..fitting.threads import at_once
from ..fitting.weighed import Weighed
from .hypothesis import Hypothesis, Start, judge, refined

NEAR = 3.0  # times the least that short pieces leave, up to which a set is fitted to free runs again
GAINS = 0.9  # of the cost of a fit that nothing led


def sought(
    weighed: Weighed, judged: np.ndarray, found: Iterable[Start], known: Iterable[Hypothesis] = (), *, rough: bool = True,
) -> list[Hypothesis]:  # fmt: skip
    """Fits several sets for good.

    Args:
        known: other hypotheses; if one of them or of these leaves little more than the noise, no other start is worth its time.
        rough: whether short pieces may lead to more.

    Returns:
        One for each set, in their order, and then one more for each that short pieces led to less.
    """
    found = list(found)
    fitted = refined(weighed, judged, found)
    free = rough and fitted and not weighed.model.starts
    if not free or any(explains(weighed, h.fit.reading) for h in (*fitted, *known)):
        return fitted
    return [*fitted, *_led(weighed, judged, found, fitted)]


def _led(weighed: Weighed, judged: np.ndarray, found: Sequence[Start], fitted: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Those of some sets that short pieces lead to less."""
    begun = raced(weighed.in_pieces, ((s.free, s.x) for s in found), near=NEAR)
    least = min((f.cost for f in begun), default=0.0)
    near = [(start, f.x, h.fit.cost) for start, f, h in zip(found, begun, fitted, strict=True) if f.cost < NEAR * least]
    again = at_once(lambda at: fit(weighed, at[0].free, at[1]), near)
    return [judge(weighed, judged, at[0].effects, f) for at, f in zip(near, again, strict=True) if f.cost < GAINS * at[2]]
