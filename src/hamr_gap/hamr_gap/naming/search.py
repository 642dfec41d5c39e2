"""The search for what is missing: all singles, all pairs and more, with the ones that look best fitted for good."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ..fitting.weighed import Weighed
from .candidates import candidates
from .exchange import exchange, twins
from .hypothesis import Hypothesis, Start
from .moves import at_both, beside, from_elsewhere, in_other_shapes, look, pairs_of
from .sensor_steps import staircases, with_stairs
from .simpler import as_narrow, in_its_place, narrowed, without
from .single_effects import single_starts
from .sought import sought
from .tried import SMALL, Search, noise_floor

NEEDED = 0.7  # of what one effect less leaves above the noise, that a larger set must leave at most
LARGEST = 3  # effects at once
LONELY = 0.1  # of the gap: an effect that leaves less is one of the answer, and no pairs are fitted without it
HOPELESS = 0.5  # of the gap: what leaves more is no name, and no simpler one is looked for
LED = 2  # effects that may lead to a better re-tune
BETTER = 0.95  # of its cost
LATE = 0.1  # of a reading's step: what an effect moves the clocks' shift by, before all is simulated with the new one
CLEAR = 12.0  # a gap that matters leaves more than this, in squared units of noise summed over all readings


def search(
    weighed: Weighed, judged: np.ndarray, base: Hypothesis, report: Callable[[str], None] = lambda _: None, *,
    known: Sequence[Start] = (), timed: bool = False,
) -> Search:  # fmt: skip
    """Names that could close the gap of a re-tuned model.

    Args:
        report: told what is being done. known: sets of effects that were found otherwise, fitted beside all others.
        timed: whether the clocks' shift is that of an effect already.
    """
    everything = candidates(weighed.model.machine, weighed.model.record)
    report("screen")
    seen = look(weighed, base.fit, everything)
    state = Search(weighed, base, seen, int(judged.sum()))
    report("singles")
    alone, wanted = single_starts(weighed, judged, base, seen, everything)
    state.tried = sought(weighed, judged, [*wanted, *known])
    state.rough = len(state.tried) > len(wanted) + len(known)
    state.tried += at_both(weighed, judged, state.tried)
    if state.best.left - noise_floor(weighed, state.best) > state.enough:
        state.tried += in_other_shapes(weighed, judged, base.fit, seen, state.tried)
    lone = sorted((h for h in state.tried if len(h.effects) == 1), key=lambda h: h.left)[:LED]  # what is known may be more than one
    late = lone[0].fit.sensors.shift
    if state.best.effects and not timed and weighed.model.pieces is None and abs(late) > LATE * weighed.model.reading_step:
        weighed = weighed.on_time(weighed.model.delay + late)  # what looked like late clocks without the effect
        return search(weighed, judged, without(weighed, judged, lone[0], lone[0].effects[0]), report, known=known, timed=True)
    led = min((without(weighed, judged, h, h.effects[0]) for h in lone), key=lambda h: h.fit.cost)
    if led.fit.cost < BETTER * base.fit.cost:  # what an effect's fit passed on the way was a better re-tune
        return search(weighed, judged, led, report, known=known, timed=timed)
    for size in range(2, LARGEST + 1):
        state.floor = noise_floor(weighed, state.best)
        before = state.best.left - state.floor
        if before * judged.sum() < CLEAR or before < state.enough:
            break
        report(f"sets of {size}")
        smaller = state.best_of(size - 1)
        if size == 2 and before > LONELY * (state.base.left - state.floor):
            state.tried += pairs_of(weighed, judged, state, everything, alone)
        state.tried += beside(weighed, judged, state, smaller, everything)
        if state.best.left - state.floor > NEEDED * before:
            break
        exchange(weighed, judged, state, everything, smaller)
    if state.best.left - state.floor < HOPELESS * (state.base.left - state.floor):
        if state.best_of(1).left - state.best.left > SMALL * (state.base.left - state.floor):
            state.tried += from_elsewhere(weighed, judged, alone, state.tried)
        twins(weighed, judged, state, everything)
        _simplify(weighed, judged, state)
    with_steps(weighed, judged, state, report)
    state.floor = noise_floor(weighed, state.best)
    return state


def _simplify(weighed: Weighed, judged: np.ndarray, state: Search) -> None:
    """Looks for simpler names of what explains the gap."""
    state.tried += in_its_place(weighed, judged, state.best)
    whole = state.best
    state.tried += narrowed(weighed, judged, whole)  # beside a simpler name others may have nothing left to do
    if (fewest := state.fewest).effects != whole.effects:
        state.tried += in_its_place(weighed, judged, fewest)
    state.tried += as_narrow(weighed, judged, state.tried)


def with_steps(weighed: Weighed, judged: np.ndarray, state: Search, report: Callable[[str], None]) -> None:
    """Steps of sensors are seen by themselves, and belong to every answer; what fits them in part can hide them."""
    of_size = [state.best_of(size) for size in sorted({len(h.effects) for h in state.tried})]
    seen = [(h, stairs) for h in (state.base, *of_size) if (stairs := staircases(weighed, judged, h))]
    if not seen:
        return
    report("steps of sensors")
    left, stairs = min(((with_stairs(weighed, judged, h, s).left, s) for h, s in seen), key=lambda found: found[0])
    if left < state.best.left:
        state.tried = [with_stairs(weighed, judged, h, stairs) for h in (state.base, *state.by_names().values())]
