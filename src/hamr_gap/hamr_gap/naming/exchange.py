"""Moves of the search that take an effect out of a set and look for what stands better in its place, or as well."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..fitting.parameters import Candidate
from ..fitting.weighed import Weighed
from .hypothesis import Hypothesis, refined
from .moves import beside, first_of_each, look, singles
from .simpler import bare, without
from .tried import RIVAL, Search

TWINS, ALIKE = 4, 0.5  # names fitted in the place of another, and how much the linear picture may leave of what it explains


def exchange(weighed: Weighed, judged: np.ndarray, state: Search, everything: Sequence[Candidate], known: Hypothesis) -> None:
    """Takes each effect of the best set out in turn and looks for what stands best beside the others, until that changes nothing.

    Of a set that explains all there is, each effect is taken out once: others may explain as much.

    Args:
        known: others beside which that has been looked for.
    """
    done = {frozenset(known.effects)}
    best = state.best
    while untried := [c for c in best.effects if frozenset(best.effects) - {c} not in done]:
        rest = frozenset(best.effects) - {untried[0]}
        done.add(rest)
        others = next((h for h in state.tried if frozenset(h.effects) == rest), None)
        others = others or without(weighed, judged, best, untried[0])
        state.tried += beside(weighed, judged, state, others, everything)
        best = state.best if best.left - state.floor > state.enough else best


def twins(weighed: Weighed, judged: np.ndarray, state: Search, everything: Sequence[Candidate]) -> None:
    """Looks for other names, at the joints of a single effect that may be the answer, about the re-tune that was found with it: one found
    without it may be so far astray that a twin promises nothing there."""
    if len(state.fewest.effects) != 1:
        return  # those of a set have been exchanged
    (c,) = state.fewest.effects
    alone = bare(weighed, state.fewest)
    known = {h.names for h in state.tried if h.left < RIVAL * state.best.left}
    wanted = [o for o in everything if set(o.joints) <= set(c.joints) and frozenset({o.name}) not in known]
    seen = look(weighed, alone, wanted, before=state.seen)
    alike = [o for o in wanted if seen.best(o)[0].cost < ALIKE * alone.cost]
    found = first_of_each(singles(weighed, alone, seen, alike), TWINS)
    state.tried += refined(weighed, judged, found, [state.best])
