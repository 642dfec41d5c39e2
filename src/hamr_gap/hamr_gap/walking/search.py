"""The search for what is missing on the ground: all in the linear picture, the best fitted alone and in pairs, and judged elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations

import numpy as np

from hamr_dynamics.effects.effects_file import OF_THE_CHASSIS

from ..fitting.parameters import Free
from ..naming.hypothesis import Hypothesis
from .candidates import PLACES, forms, kind
from .fit import ROUNDS, Fit, fit, kept, limited
from .left import left_of
from .prepare import Prepared, prepare, settled
from .screen import Screen, Solution
from .setting import Candidate, Setting, effect_parameters, setting
from .starts import best_start, start
from .walk import Walk

BRIEF, EACH = 3, 2  # rounds of a first look at every effect, and which segments it takes: every second
EVERYWHERE, MORE_PLACES = 2, 3  # effects that are looked at in all their forms, and at so many places
SINGLES = 5  # names fitted for good
KEPT, PAIRS, TOGETHER = 12, 3, 2  # singles of which pairs are made; pairs looked at, of each of two kinds; and fitted for good
POLISHED, RIVAL, TIMES = 3, 1.5, 2  # how many are taken up again, that leave less than so many times what the best leaves; and how often
SETTLING = 3  # times that the best may change hands by that
ENOUGH = 0.03  # of the gap, that another effect must promise
OUTSIDE = (*OF_THE_CHASSIS, "foot")  # what forms act on that are no part of a leg
AFAR, NEAR = 6, 2  # rounds of a look from the model as given, and how many are fitted for good that leave less than RIVAL times the re-tune
SHAKEN = 5.0  # standard deviations to either side, from which the best is fitted again
EDGE = 1e-3  # of a prior's width: a fit starts inside its bounds


@dataclass
class Search:
    """What was tried: hypotheses with effects, about the re-tuned robot."""

    prepared: Prepared
    tried: list[Hypothesis] = field(default_factory=list)

    @property
    def base(self) -> Hypothesis:
        """The re-tuned model."""
        return self.prepared.base

    @property
    def best(self) -> Hypothesis:
        """The one that leaves least."""
        return min([self.base, *self.tried], key=lambda h: h.left)

    @property
    def count(self) -> int:
        """Judged readings."""
        judged = self.prepared.parts["select"]
        return len(judged) * judged.observed.readings

    @property
    def floor(self) -> float:
        """Mean square that noise leaves."""
        return min(self.prepared.floor, self.best.left)

    def by_names(self) -> dict[frozenset, Hypothesis]:
        """The best hypothesis for every set of names."""
        found: dict[frozenset, Hypothesis] = {}
        for h in self.tried:
            if h.names not in found or h.left < found[h.names].left:
                found[h.names] = h
        return found


def search(backend: str, walk: Walk, report: Callable[[str], None] = lambda _: None) -> Search:
    """What could be missing from a backend on the ground.

    Raises:
        BagError: the walk cannot be used; one sentence.
    """
    state = Search(prepare(backend, walk, report))
    if state.base.left - state.floor < state.prepared.least:
        return state
    report("screen")
    seen = Screen(state.prepared.parts["fit"], state.base.fit, forms())
    singles = seen.singles()
    report("singles")
    state.tried += [_judged(state, found) for found in (*(_fitted(state, seen, s) for s in _best(state, seen, singles)), *_outside(state))]
    _polish(state, POLISHED if _gains(state) else 1)
    if _gains(state):
        report("sets of 2")
        state.tried += _pairs(state, seen, singles)
        _settle(state)
    if state.prepared.coarse:
        report("finer steps")
        _refine(state)
    if _gains(state):
        state.tried[state.tried.index(state.best)] = _shaken(state, state.best)
        state.prepared = state.prepared.from_(state.best.fit)
    return state


def _fitted(state: Search, seen: Screen, solution: Solution, *, brief: bool = False) -> Fit:
    """Fits effects beside all that the screen's fit has, from next to none of them; those with a threshold from where it was passed.

    Args:
        brief: for a look only, on some of the segments.
    """
    about, effects, replay = seen.about, solution.effects, state.prepared.parts["fit"]
    own, screened = effect_parameters(effects), {c.row(p) for c in effects for p in c.law.parameters if p.shape or p.screen}
    x = _inside(own, [solution.values.get(f.row, f.center) if f.row in screened else f.center for f in own])
    x = np.concatenate([about.x, x])
    some = np.arange(0, len(replay), EACH if brief else 1)
    return fit(
        replay.some(some), [*about.free, *own], x, (*about.effects, *effects), about.change[some], seen.fixed[some],
        slopes=seen.slopes[some] if brief else None, rounds=BRIEF if brief else ROUNDS,
    )  # fmt: skip


def _inside(own: Sequence[Free], x: Sequence[float]) -> np.ndarray:
    """Free numbers strictly inside their bounds, where a fit starts."""
    edge = EDGE * np.array([f.sd for f in own])
    return np.clip(x, np.array([f.low for f in own]) + edge, np.array([f.high for f in own]) - edge)


def _outside(state: Search) -> list[Fit]:
    """What acts on the chassis and the feet, from the model as given: all briefly, and for good what may do better than the re-tune.

    A re-tune without it takes it up with drives and springs, from where no step leads back; and it is little, and quick to simulate.
    """
    replay, base = state.prepared.parts["fit"], state.base.fit
    some = np.arange(0, len(replay), EACH)
    begun, most, cost = start(replay, Setting()).change, RIVAL * limited(base.residual[some]), {}

    def fitted(c: Candidate, which: np.ndarray, rounds: int) -> Fit:
        own = effect_parameters([c])
        x = np.concatenate([np.zeros(len(base.free)), _inside(own, [f.center for f in own])])
        return fit(replay.some(which), [*base.free, *own], x, (c,), begun[which], rounds=rounds)

    for c in (Candidate(effect, form.name, PLACES[kind(form)][0]) for effect, form in forms() if form.acts in OUTSIDE):
        cost[c] = fitted(c, some, AFAR).cost
    return [fitted(c, np.arange(len(replay)), ROUNDS) for c in sorted(cost, key=cost.get)[:NEAR] if cost[c] < most]


def _judged(state: Search, found: Fit) -> Hypothesis:
    return Hypothesis(found.effects, found, *state.prepared.judge("select", found.model))


def _best(state: Search, seen: Screen, singles: Sequence[Solution]) -> list[Solution]:
    """Those that look best once fitted briefly: of every effect the likeliest, of the best effects also other places and forms.

    The linear picture orders places of one effect, but not effects: contact bends it too much.
    """
    likeliest: dict[str, Solution] = {}
    for s in singles:
        likeliest.setdefault(s.effects[0].effect, s)
    cost = {s: _fitted(state, seen, s, brief=True).cost for s in likeliest.values()}
    for first in sorted(cost, key=cost.get)[:EVERYWHERE]:
        own = [s for s in singles if s.effects[0].effect == first.effects[0].effect]
        forms_here = [s for s in own if s.effects[0].place == first.effects[0].place]
        cost |= {s: _fitted(state, seen, s, brief=True).cost for s in (*_one_of_each(own, MORE_PLACES), *forms_here) if s not in cost}
    return _one_of_each(sorted(cost, key=cost.get), SINGLES)


def _one_of_each(solutions: Sequence[Solution], count: int) -> list[Solution]:
    """The best of each name."""
    first: dict[frozenset, Solution] = {}
    for s in solutions:
        first.setdefault(s.names, s)
    return list(first.values())[:count]


def _gains(state: Search) -> bool:
    """Whether the best takes off as much as counts as a gap."""
    return state.base.left - state.best.left > state.prepared.least


def _polish(state: Search, count: int) -> None:
    """Takes up so many of the best again from better starts: those of the re-tuned model may have feet where only a wrong model puts them.

    So may its parameters be where only a want of the effect has put them, and the model as given, with the effect, is the better place.
    """
    most = RIVAL * state.best.left  # of what the best leaves before any is taken up: the others may gain as much by that
    for h in sorted(state.tried, key=lambda h: h.left)[:count]:
        if h.left < most:
            state.tried[state.tried.index(h)] = _settled(state, h.fit, _from_given(state, h.fit))


def _from_given(state: Search, found: Fit) -> Fit:
    """A fit anew from the model as given, with the effects as they were found."""
    x = found.x.copy()
    x[: len(state.base.fit.free)] = 0.0
    return _from(state, found, x)


def _from(state: Search, found: Fit, x: np.ndarray) -> Fit:
    """A fit anew from other numbers (P,)."""
    replay = state.prepared.parts["fit"]
    return fit(replay, found.free, x, found.effects, start(replay, setting(found.free, x, found.effects)).change)


def _settle(state: Search) -> None:
    """The same with what is best now, until it stays the best."""
    for _ in range(SETTLING):
        at = state.tried.index(state.best)
        state.tried[at] = _settled(state, state.best.fit)
        if state.tried[at] is state.best:
            break


def _refine(state: Search) -> None:
    """Half the steps, if the best leaves less so: what a simulation recorded may have steps like these."""
    coarse, best = state.prepared, state.best
    rivals = [h for h in sorted(state.tried, key=lambda h: h.left)[:POLISHED] if h is not best and h.left < RIVAL * best.left]
    state.prepared = coarse.finer()
    if best.effects:
        again = _anew(state, best)
        if again.left < best.left:
            state.tried[state.tried.index(best)] = again
            state.prepared = state.prepared.from_(state.base.fit)
            for h in rivals:
                state.tried[state.tried.index(h)] = _anew(state, h)
            return
    elif (anew := state.prepared.from_(state.base.fit)).base.left < best.left:
        state.prepared = anew
        return
    state.prepared = coarse


def _anew(state: Search, h: Hypothesis) -> Hypothesis:
    """Fitted again with the steps of now; what was seen of its other minima still holds."""
    again = fit(state.prepared.parts["fit"], h.fit.free, h.fit.x, h.effects, h.fit.change)
    return _settled(state, replace(again, away=h.fit.away))


def _shaken(state: Search, h: Hypothesis) -> Hypothesis:
    """The same, fitted from far to either side too: where fits do not come back from there and cost no more, no interval is narrower."""
    found = h.fit
    off = SHAKEN * np.linalg.solve(np.linalg.cholesky(found.hessian).T, np.random.default_rng(0).standard_normal(len(found.x)))
    again = _settled(state, *(_from(state, found, _inside(found.free, found.x + way)) for way in (-off, off)))
    best = kept(found, again.fit)
    if again.fit.cost < found.cost and again.left < h.left:
        return replace(again, fit=best)
    return replace(h, fit=replace(found, away=best.away))


def _settled(state: Search, *begun: Fit) -> Hypothesis:
    """The best of fits, each taken up again from better starts."""
    parts = state.prepared.parts
    found = kept(*(settled(parts["fit"], each, TIMES) for each in begun))
    left = left_of(parts["select"], best_start(parts["select"], found.model, state.prepared.starts["select"].change))
    return Hypothesis(found.effects, found, *left)


def _pairs(state: Search, seen: Screen, singles: Sequence[Solution]) -> list[Hypothesis]:
    """The best single with each other candidate, in a linear picture about it; and the best pairs about the re-tune."""
    best = state.best
    gap = state.base.left - state.floor
    if not best.effects or best.left - state.floor < max(ENOUGH * gap, state.prepared.numerical**2):
        return []
    beside = Screen(state.prepared.parts["fit"], best.fit, [(e, form) for e, form in forms() if e != best.effects[0].effect])
    looks = [(beside, s) for s in _one_of_each(beside.singles(), PAIRS)]
    done = {best.names | s.names for _, s in looks}
    shapes = {s.effects[0]: tuple((p.name, s.values[s.effects[0].row(p)]) for p in s.effects[0].law.shapes) for s in singles}
    kept = [s.effects[0] for s in _one_of_each(singles, KEPT)]
    pairs = [seen.solve(pair, [shapes[c] for c in pair]) for pair in combinations(kept, 2) if pair[0].effect != pair[1].effect]
    looks += [(seen, p) for p in sorted(pairs, key=lambda p: -p.gain) if p.names not in done][:PAIRS]
    looks.sort(key=lambda look: _fitted(state, *look, brief=True).cost)
    return [_judged(state, _fitted(state, *look)) for look in looks[:TOGETHER]]
