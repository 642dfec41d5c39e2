"""Looks at what could be missing on the ground: all in the linear picture, more of it briefly, and what looks best fitted for good."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from hamr_dynamics.effects.effects_file import OF_THE_CHASSIS

from ..fitting.parameters import Free
from .candidates import PLACES, forms, kind
from .fit import ROUNDS, Fit, fit, limited
from .screen import Screen, Solution
from .setting import Candidate, Setting, effect_parameters
from .starts import start
from .state import Search

BRIEF, EACH = 3, 2  # rounds of a first look at every effect, and which segments it takes: every second
EVERYWHERE, MORE_PLACES = 2, 3  # effects that are looked at in all their forms, and at so many places
SINGLES = 5  # names fitted for good
KEPT, PAIRS, TOGETHER = 12, 3, 2  # singles of which pairs are made; pairs looked at, of each of two kinds; and fitted for good
ENOUGH = 0.03  # of the gap, that another effect must promise
RIVAL = 1.5  # times what another leaves, up to which it may yet be the better one
OUTSIDE = (*OF_THE_CHASSIS, "foot")  # what forms act on that are no part of a leg
AFAR, NEAR = 6, 2  # rounds of a look from the model as given, and how many are fitted for good that leave less than RIVAL times the re-tune
EDGE = 1e-3  # of a prior's width: a fit starts inside its bounds


def screen(state: Search) -> Screen:
    """Everything that could be missing, in a linear picture about the re-tuned robot."""
    return Screen(state.prepared.parts["fit"], state.base.fit, forms())


def alone(state: Search, seen: Screen, singles: Sequence[Solution]) -> list[Fit]:
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
    return [_fitted(state, seen, s) for s in _one_of_each(sorted(cost, key=cost.get), SINGLES)]


def outside(state: Search) -> list[Fit]:
    """What acts on the chassis and the feet, from the model as given: all briefly, and for good what may do better than the re-tune.

    A re-tune without it takes it up with drives and springs, from where no step leads back; and it is little, and quick to simulate.
    """
    replay, base = state.prepared.parts["fit"], state.base.fit
    some = np.arange(0, len(replay), EACH)
    begun, most, cost = start(replay, Setting()).change, RIVAL * limited(base.residual[some]), {}

    def fitted(c: Candidate, which: np.ndarray, rounds: int) -> Fit:
        own = effect_parameters([c])
        x = np.concatenate([np.zeros(len(base.free)), inside(own, [f.center for f in own])])
        return fit(replay.some(which), [*base.free, *own], x, (c,), begun[which], rounds=rounds)

    for c in (Candidate(effect, form.name, PLACES[kind(form)][0]) for effect, form in forms() if form.acts in OUTSIDE):
        cost[c] = fitted(c, some, AFAR).cost
    return [fitted(c, np.arange(len(replay)), ROUNDS) for c in sorted(cost, key=cost.get)[:NEAR] if cost[c] < most]


def pairs(state: Search, seen: Screen, singles: Sequence[Solution]) -> list[Fit]:
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
    return [_fitted(state, *look) for look in looks[:TOGETHER]]


def _fitted(state: Search, seen: Screen, solution: Solution, *, brief: bool = False) -> Fit:
    """Fits effects beside all that the screen's fit has, from next to none of them; those with a threshold from where it was passed.

    Args:
        brief: for a look only, on some of the segments.
    """
    about, effects, replay = seen.about, solution.effects, state.prepared.parts["fit"]
    own, screened = effect_parameters(effects), {c.row(p) for c in effects for p in c.law.parameters if p.shape or p.screen}
    x = inside(own, [solution.values.get(f.row, f.center) if f.row in screened else f.center for f in own])
    x = np.concatenate([about.x, x])
    some = np.arange(0, len(replay), EACH if brief else 1)
    return fit(
        replay.some(some), [*about.free, *own], x, (*about.effects, *effects), about.change[some], seen.fixed[some],
        slopes=seen.slopes[some] if brief else None, rounds=BRIEF if brief else ROUNDS,
    )  # fmt: skip


def inside(own: Sequence[Free], x: Sequence[float]) -> np.ndarray:
    """Free numbers strictly inside their bounds, where a fit starts."""
    edge = EDGE * np.array([f.sd for f in own])
    return np.clip(x, np.array([f.low for f in own]) + edge, np.array([f.high for f in own]) - edge)


def _one_of_each(solutions: Sequence[Solution], count: int) -> list[Solution]:
    """The best of each name."""
    first: dict[frozenset, Solution] = {}
    for s in solutions:
        first.setdefault(s.names, s)
    return list(first.values())[:count]
