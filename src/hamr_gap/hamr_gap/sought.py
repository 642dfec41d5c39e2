"""Fits of sets of effects, from where short pieces of the record lead as well, where no set explains what there is.

What sticks, plays or hits a stop makes the cost of a free run rough: a run that lets go at another time than the machine did is lost
from there on, and fits rest in the minima that this makes. A short run from a measured start has no time for that (multiple shooting,
Bock 1983), so fits of these end near the right numbers, from which a free run is fitted for good.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from .fit import ROUGH, Fit, fit
from .hypothesis import Hypothesis, Start, judge, refined
from .threads import at_once
from .weighed import Weighed

STEPS, TOLERANCE = 15, 3e-3  # of fits that lead only
NEAR = 3.0  # times the least that short pieces leave, up to which a set is fitted to free runs again


def sought(weighed: Weighed, judged: np.ndarray, found: Iterable[Start], known: Iterable[Hypothesis] = ()) -> list[Hypothesis]:
    """Fits several sets for good, in their order.

    Args:
        known: other hypotheses; if one of them or of these leaves little more than the noise, no other start is worth its time.
    """
    found = list(found)
    fitted = refined(weighed, judged, found)
    if not fitted or weighed.model.pieces is not None or any(_explained(weighed, h.fit) for h in (*fitted, *known)):
        return fitted
    short = weighed.in_pieces()
    begun = at_once(lambda start: fit(short, start.free, start.x, steps=STEPS, tolerance=TOLERANCE), found)
    least = min(f.cost for f in begun)
    near = [k for k, f in enumerate(begun) if f.cost < NEAR * least]
    for k, f in zip(near, at_once(lambda k: fit(weighed, found[k].free, begun[k].x), near), strict=True):
        if f.cost < fitted[k].fit.cost:
            fitted[k] = judge(weighed, judged, found[k].effects, f)
    return fitted


def _explained(weighed: Weighed, found: Fit) -> bool:
    return weighed.missed(found.reading).max() < ROUGH
