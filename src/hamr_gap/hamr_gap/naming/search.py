"""The search for what is missing: all singles, all pairs and more, with the ones that look best fitted for good."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..data.readings import noise_of
from ..fitting.parameters import Candidate
from ..fitting.weighed import Weighed
from .blocks import THROUGHOUT, better
from .candidates import candidates
from .hypothesis import Hypothesis, Start, residual
from .moves import at_both, beside, in_other_shapes, look, pairs_of
from .screen import Screen
from .sensor_steps import staircases, with_stairs
from .simpler import HARMLESS, as_narrow, in_its_place, narrowed, without
from .single_effects import single_starts
from .sought import sought

EARNED = 1.01  # by how much each further parameter of a form must lower what is left
AS_WELL, RIVAL_FORMS = 1.03, 3  # times what one form leaves, that others may leave to do about as well, and how many with it
RIVAL = 4.0  # times what more effects leave, that fewer may leave and be as probable
NEEDED = 0.7  # of what one effect less leaves above the noise, that a larger set must leave at most
ENOUGH = 0.001  # of the gap: nothing smaller is looked for
LARGEST = 3  # effects at once
HOPELESS = 0.5  # of the gap: what leaves more is no name, and no simpler one is looked for
LED = 2  # effects that may lead to a better re-tune
BETTER = 0.95  # of its cost
LATE = 0.1  # of a reading's step: what an effect moves the clocks' shift by, before all is simulated with the new one
CLEAR = 12.0  # a gap that matters leaves more than this, in squared units of noise summed over all readings
FAINT = 1.0  # squared units of noise of a reading: less than half a floor is not looked into further
FLOOR_ERROR = 0.03  # of the estimate of what noise leaves


@dataclass
class Search:
    """What was tried.

    Attributes:
        weighed: the model that was tried, perhaps better timed than the one the search began with.
        base: the re-tuned model without effects, perhaps better than that one too. seen: the linear picture about it.
        count: judged readings. tried: all hypotheses with effects. floor: mean square that noise alone leaves.
        rough: whether short pieces led fits of single effects to less.
    """

    weighed: Weighed
    base: Hypothesis
    seen: Screen
    count: int
    tried: list[Hypothesis] = field(default_factory=list)
    floor: float = 1.0
    rough: bool = False

    @property
    def best(self) -> Hypothesis:
        """The one that leaves least."""
        return min([self.base, *self.tried], key=lambda h: h.left)

    @property
    def fewest(self) -> Hypothesis:
        """The one with fewest effects that may yet be the answer; of as many, the one that leaves least."""
        alike = (h for h in self.tried if h.left < RIVAL * self.best.left)
        return min(alike, key=lambda h: (len(h.effects), h.left), default=self.base)

    @property
    def enough(self) -> float:
        """Mean square above the noise that is not looked into further."""
        return max(FAINT, ENOUGH * (self.base.left - self.floor))

    def best_of(self, size: int) -> Hypothesis:
        """The same of those with so many effects."""
        return min((h for h in self.tried if len(h.effects) == size), key=lambda h: h.left)

    def by_names(self) -> dict[frozenset, Hypothesis]:
        """The best hypothesis for every set of names; of forms the one with fewest parameters that does as well but for a few blocks."""
        forms: dict[frozenset, list[Hypothesis]] = {}
        for h in sorted(self.tried, key=lambda h: h.left * EARNED**h.parameters):
            forms.setdefault(h.names, []).append(h)
        return {names: _simplest(found) for names, found in forms.items()}

    def forms_of(self, h: Hypothesis) -> list[Hypothesis]:
        """A hypothesis, and the other forms of its name that do about as well; the best first of these."""
        best = {h.effects: h}
        for other in sorted(self.tried, key=lambda o: o.left):
            if other.names == h.names and other.left < AS_WELL * h.left:
                best.setdefault(other.effects, other)
        return list(best.values())[:RIVAL_FORMS]


def _simplest(forms: Sequence[Hypothesis]) -> Hypothesis:
    """Of forms of one name, the best first, the one with fewest parameters that is no worse throughout: chance may be all there is."""
    best = forms[0]
    alike = [h for h in forms if h.left < HARMLESS * best.left and better(h.blocks, best.blocks) < THROUGHOUT]
    return min(alike, key=lambda h: h.parameters, default=best)


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
        state.tried += pairs_of(weighed, judged, base.fit, seen, everything, alone, rough=state.rough) if size == 2 else []
        state.tried += beside(weighed, judged, smaller, everything, state.best, rough=state.rough)
        if state.best.left - state.floor > NEEDED * before:
            break
        _exchange(weighed, judged, state, everything, smaller)
    if state.best.left - state.floor < HOPELESS * (state.base.left - state.floor):
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


def _exchange(weighed: Weighed, judged: np.ndarray, state: Search, everything: Sequence[Candidate], known: Hypothesis) -> None:
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
        state.tried += beside(weighed, judged, others, everything, state.best, rough=state.rough)
        best = state.best if best.left - state.floor > state.enough else best


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


def noise_floor(weighed: Weighed, best: Hypothesis) -> float:
    """Mean square that noise and the simulation's own error leave, from differences of the best hypothesis' residual."""
    noise = float(np.mean(noise_of(residual(weighed, best.fit)) ** 2))
    return min(noise + weighed.model.mean * weighed.numerical**2, best.left)
