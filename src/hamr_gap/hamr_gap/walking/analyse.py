"""Find and name for the whole robot on the ground: from a walk to a verdict's word, the answers that are credible, and the evidence."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from threadpoolctl import threadpool_limits

from ..judging.analyse import CONFIRMED, SIGNIFICANT
from ..judging.weigh import Weight, credible, weigh
from ..naming.blocks import better
from ..naming.hypothesis import Hypothesis
from .left import exceeds, left_of
from .search import search
from .starts import start
from .state import Search
from .walk import Walk

UNEXPLAINED = 2.5  # times what noise leaves: a re-tune that leaves more explains nothing; contacts that went another way left up to 1.7


@dataclass(frozen=True)
class Analysis:
    """A verdict and all that led to it.

    Attributes:
        search. weights: of all names tried. word: the verdict. chosen: the credible answers, none where nothing is missing.
        best: the model that is kept. evidence: t over blocks by which an effect leaves less than the re-tune, on the segments that selected
            it and on fresh ones.
    """

    search: Search
    weights: list[Weight]
    word: str
    chosen: list[Weight]
    best: Hypothesis
    evidence: tuple[float, float]

    def left(self, role: str) -> dict[str, float]:
        """Mean squares, in units of the noise, that the re-tune and the best leave on a role, and what noise alone leaves."""
        replay, base = self.search.prepared.parts[role], self.search.base.fit.model
        begun = start(replay, base)
        best = left_of(replay, start(replay, self.best.fit.model, begun.change))[0]
        return {"base": left_of(replay, begun)[0], "best": best, "floor": self.search.floor}


@threadpool_limits.wrap(limits=1)  # as for legs
def analyse(backend: str, walk: Walk, report: Callable[[str], None] = lambda _: None) -> Analysis:
    """Finds the gap between a backend and a walk, and names what is missing.

    Raises:
        BagError: the walk cannot be used; one sentence.
    """
    state = search(backend, walk, report)
    report("intervals")
    prepared = state.prepared
    weights = weigh(state, prepared.least)
    evidence = _evidence(state)
    if state.gains and evidence[0] > SIGNIFICANT and evidence[1] > CONFIRMED:
        chosen = credible(weights)
        word = "unknown" if chosen[0].hypothesis is None else "named" if len(chosen) == 1 else "ambiguous"
        return Analysis(state, weights, word, chosen, chosen[0].hypothesis or state.base, evidence)
    if state.base.left > UNEXPLAINED * state.floor:
        return Analysis(state, weights, "unknown", [Weight(None, 1.0, 1.0)], state.base, evidence)
    tuned = better(prepared.raw.blocks, state.base.blocks) > SIGNIFICANT and exceeds(prepared.raw, state.base, prepared.least)
    return Analysis(state, weights, "parameters_only" if tuned else "no_significant_gap", [], state.base, evidence)


def _evidence(state: Search) -> tuple[float, float]:
    best = state.best
    if not best.effects:
        return 0.0, 0.0
    prepared = state.prepared
    fresh = left_of(prepared.parts["calibrate"], prepared.starts["calibrate"])[1]
    return better(state.base.blocks, best.blocks), better(fresh, prepared.judge("calibrate", best.fit.model)[1])
