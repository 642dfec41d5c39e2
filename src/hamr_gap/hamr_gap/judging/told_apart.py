"""The names of an ambiguous answer weighed once more, by the readings they were fitted to as well.

What was held out says which names there may be; it is a quarter of the readings. Of names that it leaves the fitted ones, twice as many,
say more: each parameter takes as much from what is left of them as chance leaves of its share, which is added again (Akaike 1974).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..fitting.weighed import Weighed
from ..naming.blocks import THROUGHOUT, better
from ..naming.hypothesis import Hypothesis, left_of
from ..naming.tried import Search
from .weigh import Weight, credible, log_odds, scale_of


def told_apart(weighed: Weighed, judged: np.ndarray, state: Search, weights: Sequence[Weight]) -> list[Weight]:
    """Weights, most probable first, of which the names of a credible set share what they had otherwise.

    The name that leaves least of all readings counts by them, and so do those that leave more throughout; the others count by the
    readings held out alone, for what a law's form misses here or there decides nothing.

    Args:
        judged: (n, channels) readings held out. weights: as of `weigh`, by these.
    """
    chosen = [w for w in credible(weights) if w.hypothesis]
    if len(chosen) < 2:
        return list(weights)
    own = {by_all(weighed, judged, h): h for h in state.tried}
    every = replace(state, base=by_all(weighed, judged, state.base), tried=list(own), count=state.count + int(weighed.chosen.sum()))
    found = every.by_names()
    named = [found[w.hypothesis.names] for w in chosen]
    best = min(named, key=lambda h: h.left)
    _, _, least = scale_of(state, state.by_names().values())
    floor, gap, least_of_all = scale_of(every, found.values())
    held_out = _against_best([w.left for w in chosen], least)
    by_every = _against_best([max(h.left - floor, 0.0) / gap for h in named], least_of_all)
    counts = [h is best or better(h.blocks, best.blocks) >= THROUGHOUT for h in named]
    p = np.array([w.probability for w in chosen])
    told = p * np.exp(np.where(counts, by_every - held_out, 0.0))
    told *= p.sum() / told.sum()
    again = [replace(w, hypothesis=own[h], probability=float(x)) for w, h, x in zip(chosen, named, told, strict=True)]
    return sorted([*again, *(w for w in weights if w not in chosen)], key=lambda w: -w.probability)


def by_all(weighed: Weighed, judged: np.ndarray, h: Hypothesis) -> Hypothesis:
    """A hypothesis with what it leaves of the readings held out and the fitted ones, as of `left_of`."""
    held, fitted = int(judged.sum()), int(weighed.chosen.sum())
    left, blocks = left_of(weighed, weighed.chosen, h.fit.reading)
    unseen = 1.0 + 2.0 * h.parameters / fitted
    together = (held * h.left + fitted * unseen * left) / (held + fitted)
    return replace(h, left=together, blocks=np.concatenate([h.blocks, unseen * blocks]))


def _against_best(left: Sequence[float], least: float) -> np.ndarray:
    """Log odds of shares of the gap against the least of them."""
    odds = np.array([log_odds(share, least) for share in left])
    return odds - odds.max()
