"""What has a name in a gap that no names close: real machines have small laws of their own beside the one that matters."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hamr_dynamics.effects.library import library

from ..fitting.parameters import Candidate
from ..fitting.weighed import Weighed
from ..naming.hypothesis import Hypothesis
from ..naming.simpler import without
from ..naming.tried import Search
from .weigh import akin, floor_of

NEEDED = 1.5  # times what the likeliest set leaves of the gap, that whatever lacks a name or its like must leave
MOST = 0.3  # of the gap, that names may leave to explain part of it: of most laws outside the library they left more
SIZE, SECOND = 2, 0.5  # effects at most, for three imitate anything; what a second one must leave at most of what one leaves


def part_of(weighed: Weighed, judged: np.ndarray, state: Search) -> Hypothesis | None:
    """The effects that are in all sets that leave about as little as the likeliest, fitted without what else is there; None if none is.

    Of effects that are alike the simplest: what has another as its special case is not told from it where something else is missing.
    """
    found = sorted(state.by_names().values(), key=lambda h: h.left)
    floor = floor_of(state.floor, found)
    few = (h for h in found if len(h.effects) <= SIZE)
    best = min(few, key=lambda h: (h.left - floor) / SECOND ** len(h.effects), default=None)
    if best is None or best.left - floor > MOST * (state.base.left - floor):
        return None
    alike = [h for h in found if h.left - floor <= NEEDED * (best.left - floor)]
    part = min(alike, key=lambda h: sum(bool(library()[c.effect].contains) for c in needed(h.effects, alike)))
    kept = needed(part.effects, alike)
    for c in part.effects if kept else ():
        part = part if c in kept else without(weighed, judged, part, c)
    return _plainest(part, state, floor) if kept else None


def _plainest(part: Hypothesis, state: Search, floor: float) -> Hypothesis:
    """The plainest form of the same names that leaves about as little: with what a richer one has besides it takes up what is unknown."""
    alike = [h for h in (part, *state.tried) if h.names == part.names and h.left - floor <= NEEDED * (part.left - floor)]
    return min(alike, key=lambda h: (h.parameters, sum(_place(c) for c in h.effects), h.left))


def _place(c: Candidate) -> int:
    """Of a form, among those of its effect: the plainest come first."""
    return [form.name for form in library()[c.effect].forms].index(c.form)


def needed(effects: Sequence[Candidate], alike: Sequence[Hypothesis]) -> list[Candidate]:
    """Those of some effects that are in every one of some sets, or their likes."""
    return [c for c in effects if all(any(akin(c.effect, other.effect) for other in h.effects) for h in alike)]
