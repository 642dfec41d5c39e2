"""The search for what is missing: all singles, all pairs and more, with the ones that look best fitted for good."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations

import numpy as np

from .candidates import candidates
from .fit import Fit, fit
from .hypothesis import Hypothesis, Start, refine, residual, starts
from .parameters import Candidate
from .record import noise_of
from .screen import Screen, screen
from .staircase import staircases, with_stairs
from .weighed import Weighed

SINGLES = 10  # names fitted for good
ALL_FORMS = 3  # of these, in all their forms
PAIRS = 5
PAIRS_SEEN = 60  # pairs simulated
MORE = 6
SHAPES = 2  # sets of shapes of each candidate that are simulated
ENOUGH = 0.001  # of the gap: nothing smaller is looked for
LARGEST = 3  # effects at once
LED = 2  # effects that may lead to a better re-tune
BETTER = 0.95  # of its cost
CLEAR = 12.0  # a gap that matters leaves more than this, in squared units of noise summed over all readings
FAINT = 1.0  # squared units of noise of a reading: less than half a floor is not looked into further


@dataclass
class Search:
    """What was tried.

    Attributes:
        base: the re-tuned model without effects, perhaps better than the one the search began with. seen: the linear picture about it.
        tried: all hypotheses with effects. floor: mean square that noise alone leaves.
    """

    base: Hypothesis
    seen: Screen
    tried: list[Hypothesis] = field(default_factory=list)
    floor: float = 1.0

    @property
    def best(self) -> Hypothesis:
        """The one that leaves least."""
        return min([self.base, *self.tried], key=lambda h: h.left)

    def by_names(self) -> dict[frozenset, Hypothesis]:
        """The best hypothesis for every set of names."""
        found: dict[frozenset, Hypothesis] = {}
        for h in self.tried:
            if h.names not in found or h.left < found[h.names].left:
                found[h.names] = h
        return found


def search(weighed: Weighed, judged: np.ndarray, base: Hypothesis, report: Callable[[str], None] = lambda _: None) -> Search:
    """Names that could close the gap of a re-tuned model.

    Args:
        report: told what is being done.
    """
    count = int(judged.sum())
    everything = candidates(weighed.model.machine, weighed.model.record.channels)
    report("screen")
    seen = _look(weighed, base.fit, everything)
    state = Search(base, seen)
    report("singles")
    alone = _singles(weighed, base.fit, seen, everything)
    given = fit(weighed, base.fit.free, np.zeros(len(base.fit.free)), steps=0)  # a strong effect leads the re-tune astray
    alone += _singles(weighed, given, _look(weighed, given, everything, like=base.fit), everything)
    state.tried += [refine(weighed, judged, start) for start in _forms(alone)]
    best = sorted(state.tried, key=lambda h: h.left)[:LED]
    led = min((_without(weighed, judged, h, h.effects[0]) for h in best), key=lambda h: h.fit.cost)
    if led.fit.cost < BETTER * base.fit.cost:  # what an effect's fit passed on the way was a better re-tune
        return search(weighed, judged, led, report)
    for size in range(2, LARGEST + 1):
        state.floor = noise_floor(weighed, state.best)
        excess = state.best.left - state.floor
        if excess * count < CLEAR or excess < max(FAINT, ENOUGH * (base.left - state.floor)):
            break
        report(f"sets of {size}")
        new = _pairs(weighed, judged, base.fit, seen, alone) if size == 2 else []
        new += _beside(weighed, judged, min((h for h in state.tried if len(h.effects) == size - 1), key=lambda h: h.left), everything)
        before = state.best.left
        state.tried += new
        if min((h.left for h in new), default=before) - state.floor > 0.7 * (before - state.floor):
            break
        _exchange(weighed, judged, state, everything)
    if stairs := staircases(weighed, judged, state.best):
        report("steps of sensors")  # seen by themselves, they belong to every answer
        state.tried = [with_stairs(weighed, judged, h, stairs) for h in (base, *state.by_names().values())]
    state.floor = noise_floor(weighed, state.best)
    return state


def _look(weighed: Weighed, about: Fit, wanted: Sequence[Candidate], *, like: Fit | None = None) -> Screen:
    """The linear picture about a fit, of responses about as large as what a fit (that one, if not another) leaves."""
    left = residual(weighed, like or about)[weighed.chosen]
    return screen(weighed, about, wanted, amplitude=float(np.sqrt(np.mean(left**2))))


def _singles(weighed: Weighed, about: Fit, seen: Screen, wanted: Sequence[Candidate]) -> list[Start]:
    """A start for every candidate and its best shapes."""
    return starts(weighed, about, seen, [((c,), s) for c in wanted for s in seen.best(c, SHAPES)])


def _first(found: Sequence[Start], count: int) -> list[Start]:
    """The starts that leave least, one for each set of names."""
    best: dict[frozenset, Start] = {}
    for start in sorted(found, key=lambda s: s.cost):
        best.setdefault(frozenset(c.name for c in start.effects), start)
    return list(best.values())[:count]


def _forms(found: Sequence[Start]) -> list[Start]:
    """The first names, the very first in every form: all forms of a name come before a second name."""
    first = _first(found, SINGLES)
    every = {frozenset(c.name for c in s.effects) for s in first[:ALL_FORMS]}
    best: dict[Candidate, Start] = {}
    for start in sorted(found, key=lambda s: s.cost):
        if frozenset(c.name for c in start.effects) in every:
            best.setdefault(start.effects[0], start)
    return [*best.values(), *first[ALL_FORMS:]]


def _pairs(weighed: Weighed, judged: np.ndarray, about: Fit, seen: Screen, alone: Sequence[Start]) -> list[Hypothesis]:
    """All pairs in the linear picture, since a pair can explain what neither of its members does; the best simulated, then fitted."""
    kept = [start.effects[0] for start in _first(alone, len(alone))]
    best = {c: seen.best(c)[0] for c in kept}
    pairs = {(a, b): seen.solve((*best[a].chosen, *best[b].chosen)) for a, b in combinations(kept, 2) if a.effect != b.effect}
    wanted = sorted(pairs, key=lambda pair: pairs[pair].cost)[:PAIRS_SEEN]
    return [refine(weighed, judged, s) for s in _first(starts(weighed, about, seen, [(pair, pairs[pair]) for pair in wanted]), PAIRS)]


def _beside(weighed: Weighed, judged: np.ndarray, others: Hypothesis, everything: Sequence[Candidate]) -> list[Hypothesis]:
    """One more effect beside others, in a linear picture about them; the first name in all its forms."""
    wanted = [c for c in everything if all(c.effect != e.effect for e in others.effects)]
    found = _singles(weighed, others.fit, _look(weighed, others.fit, wanted), wanted)
    starts_ = _first(found, MORE)
    best: dict[Candidate, Start] = {}
    for start in sorted(found, key=lambda s: s.cost):
        if starts_ and start.effects[0].name == starts_[0].effects[0].name:
            best.setdefault(start.effects[0], start)
    return [replace(refine(weighed, judged, s), effects=(*others.effects, *s.effects)) for s in [*best.values(), *starts_[1:]]]


def _exchange(weighed: Weighed, judged: np.ndarray, state: Search, everything: Sequence[Candidate]) -> None:
    """Takes each effect of the best set out in turn and looks for what stands best beside the others, until that changes nothing."""
    done: set[frozenset] = set()
    while open_ := [c for c in state.best.effects if frozenset(state.best.effects) - {c} not in done]:
        rest = tuple(c for c in state.best.effects if c != open_[0])
        done.add(frozenset(rest))
        alone = next((h for h in state.tried if frozenset(h.effects) == frozenset(rest)), None)
        state.tried += _beside(weighed, judged, alone or _without(weighed, judged, state.best, open_[0]), everything)


def _without(weighed: Weighed, judged: np.ndarray, h: Hypothesis, effect: Candidate) -> Hypothesis:
    """A hypothesis fitted again without one of its effects."""
    rows = {row for shape in (False, True) for row, _ in effect.rows(shape=shape)}
    kept = [i for i, f in enumerate(h.fit.free) if f.row not in rows]
    rest = tuple(c for c in h.effects if c != effect)
    return refine(weighed, judged, Start(rest, tuple(h.fit.free[i] for i in kept), h.fit.x[kept], np.inf))


def noise_floor(weighed: Weighed, best: Hypothesis) -> float:
    """Mean square that noise and the simulation's own error leave, from differences of the best hypothesis' residual."""
    noise = float(np.mean(noise_of(residual(weighed, best.fit)) ** 2))
    return min(noise + weighed.model.mean * weighed.numerical**2, best.left)
