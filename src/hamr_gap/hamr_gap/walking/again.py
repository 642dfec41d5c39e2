"""The best of a search on the ground taken up again: from better starts, in finer steps, from far away."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .fit import Fit, fit, kept
from .left import Judged, left_of
from .looks import RIVAL, inside
from .prepare import settled
from .setting import setting
from .starts import best_start, start
from .state import Search

POLISHED, TIMES = 3, 2  # how many are taken up again, if the best gains anything; and how often
SETTLING = 3  # times that the best may change hands by that
SHAKEN = 5.0  # standard deviations to either side, from which the best is fitted again


def polish(state: Search) -> None:
    """Takes up the best and its rivals from better starts: those of the re-tuned model may have feet where only a wrong model puts them.

    So may its parameters be where only a want of the effect has put them, and the model as given, with the effect, is the better place.
    """
    most = RIVAL * state.best.left  # of what the best leaves before any is taken up: the others may gain as much by that
    for h in sorted(state.tried, key=lambda h: h.left)[: POLISHED if state.gains else 1]:
        if h.left < most:
            state.tried[state.tried.index(h)] = _settled(state, h.fit, _from_given(state, h.fit))


def settle(state: Search) -> None:
    """The same with what is best now, until it stays the best."""
    for _ in range(SETTLING):
        at = state.tried.index(state.best)
        state.tried[at] = _settled(state, state.best.fit)
        if state.tried[at] is state.best:
            break


def refine(state: Search) -> None:
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


def shake(state: Search) -> None:
    """Fits the best from far to either side too: where fits do not come back from there and cost no more, no interval is narrower."""
    at, found = state.tried.index(state.best), state.best.fit
    off = SHAKEN * np.linalg.solve(np.linalg.cholesky(found.hessian).T, np.random.default_rng(0).standard_normal(len(found.x)))
    again = _settled(state, *(_from(state, found, inside(found.free, found.x + way)) for way in (-off, off)))
    best = kept(found, again.fit)
    if again.fit.cost < found.cost and again.left < state.best.left:
        state.tried[at] = replace(again, fit=best)
    else:
        state.tried[at] = replace(state.best, fit=replace(found, away=best.away))
    state.prepared = state.prepared.from_(state.best.fit)


def _anew(state: Search, h: Judged) -> Judged:
    """Fitted again with the steps of now; what was seen of its other minima still holds."""
    again = fit(state.prepared.parts["fit"], h.fit.free, h.fit.x, h.effects, h.fit.change)
    return _settled(state, replace(again, away=h.fit.away))


def _from_given(state: Search, found: Fit) -> Fit:
    """A fit anew from the model as given, with the effects as they were found."""
    x = found.x.copy()
    x[: len(state.base.fit.free)] = 0.0
    return _from(state, found, x)


def _from(state: Search, found: Fit, x: np.ndarray) -> Fit:
    """A fit anew from other numbers (P,)."""
    replay = state.prepared.parts["fit"]
    return fit(replay, found.free, x, found.effects, start(replay, setting(found.free, x, found.effects)).change)


def _settled(state: Search, *begun: Fit) -> Judged:
    """The best of fits, each taken up again from better starts."""
    parts = state.prepared.parts
    found = kept(*(settled(parts["fit"], each, TIMES) for each in begun))
    left = left_of(parts["select"], best_start(parts["select"], found.model, state.prepared.starts["select"].change))
    return Judged(found.effects, found, *left)
