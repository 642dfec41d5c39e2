"""Find and name, for one machine: from a record to a verdict."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from threadpoolctl import threadpool_limits

from hamr_dynamics.effects.library import library
from hamr_dynamics.machine import Machine

from ..data.record import Record
from ..fitting.roles import mask
from ..naming.blocks import better
from ..naming.candidates import candidates, missing, of_one_size
from ..naming.hypothesis import Hypothesis, judge, left_of, residual, settled
from ..naming.prepare import Prepared
from ..naming.searched import searched
from ..naming.tried import Search, noise_floor
from .colour import correlation_time
from .detect import detectable
from .part import part_of
from .stated import Stated, at_bounds, degenerate, poor, stated
from .told_apart import told_apart
from .unexplained import ALONE, structural
from .verdict import Answer, Gap, Verdict
from .weigh import Weight, credible, weigh
from .where import where

SIGNIFICANT = 4.5  # t over blocks on the readings that selected, with many names tried
CONFIRMED = 2.0  # t over blocks on readings that nothing has seen
SURE = 2.0  # times as much as is significant, is sure without as much on readings that nothing has seen, which may be few
SHARE = 0.25  # of a gap, that the best of all names must explain, or the gap has another cause
NOT_REFUTED = 0.975  # of probability, that answers hold which other machines built alike may speak for
SELDOM = 2.0  # how many times surer a likelihood ratio must be, which trusts its noise, than t over blocks, which does not


@dataclass(frozen=True)
class Analysis:
    """A verdict and all that led to it, for reports.

    Attributes:
        chosen: the verdict's set, settled. beyond: what is less probable than these, but holds `NOT_REFUTED` together with them.
        part: what of an unknown answer has a name. said: the best, the chosen and the part in SI.
    """

    prepared: Prepared
    search: Search
    weights: list[Weight]
    chosen: list[Weight]
    beyond: list[Weight]
    part: Hypothesis | None
    said: dict[Hypothesis, Stated]
    best: Hypothesis
    verdict: Verdict
    evidence: tuple[float, float]

    def left(self, part: np.ndarray) -> dict[str, float]:
        """Mean squares, in units of the noise, that the re-tune and the best hypothesis leave on a role, and what noise alone leaves."""
        weighed = self.prepared.weighed
        rows = mask(weighed.model, part)
        base, best = (judge(weighed, rows, (), h.fit).left for h in (self.prepared.base, self.best))
        return {"base": base, "best": best, "floor": noise_floor(weighed, judge(weighed, rows, (), self.best.fit))}


@threadpool_limits.wrap(limits=1)  # cores are busy with runs; and sums in another order would have other last digits
def analyse(machine: Machine, record: Record, report: Callable[[str], None] = lambda _: None) -> Analysis:
    """Finds the gap between a machine's model and a record of it, and names what is missing.

    Raises:
        BagError: the record cannot be used; one sentence.
    """
    prepared, state = searched(machine, record, report)
    least = prepared.weighed.least
    weights = told_apart(prepared.weighed, prepared.judged, state, weigh(state, least))
    evidence = _evidence(prepared, state)
    explained = prepared.base.left - state.best.left
    confirmed = 0.0 if evidence[0] > SURE * SIGNIFICANT else CONFIRMED
    helped = explained > least and evidence[0] > SIGNIFICANT and evidence[1] > confirmed
    named = helped and explained > SHARE * (prepared.base.left - state.floor)
    loud = helped and state.best.left > ALONE**2  # names help, though not enough, and no noise leaves so much
    if not named and (loud or structural(prepared.weighed, prepared.judged, prepared.base.fit)):
        verdict, best, chosen, beyond = "unknown", state.best, [Weight(None, 1.0, 1.0)], []
    elif not named:
        verdict, best, chosen, beyond = _nothing(prepared), prepared.base, [], []
    else:
        chosen = credible(weights)
        beyond = credible(weights, NOT_REFUTED)[len(chosen) :]
        best = next((w.hypothesis for w in weights if w.hypothesis is not None), state.best)
        verdict = "unknown" if chosen[0].hypothesis is None else "named" if len(chosen) == 1 else "ambiguous"
    report("intervals")
    part = part_of(prepared.weighed, prepared.judged, state) if verdict == "unknown" else None
    fitted = dict.fromkeys(h for h in (best, part, *(w.hypothesis for w in chosen)) if h)
    fitted = {h: settled(prepared.weighed, prepared.judged, h) for h in fitted}
    best, part, chosen = fitted[best], fitted.get(part), [replace(w, hypothesis=fitted.get(w.hypothesis)) for w in chosen]
    said = {h: stated(prepared, h) for h in fitted.values()}
    answers = [answer_of(state, w, said.get(w.hypothesis or part)) for w in chosen]
    whole = _state(verdict, prepared, state, answers, said[best])
    return Analysis(prepared, state, weights, chosen, beyond, part, said, best, whole, evidence)


def _evidence(prepared: Prepared, state: Search) -> tuple[float, float]:
    """How surely some effect leaves less than the re-tune, in standard deviations: on the readings that selected it, and on fresh ones.

    The larger of two: t over blocks, for what acts all the time, and the root of twice the log likelihood ratio with the noise that
    the best leaves and its correlation time, for what acts seldom (a stop that is hit twice a second).
    """
    best, weighed = state.best, prepared.weighed
    if not best.effects:
        return 0.0, 0.0
    fresh = mask(weighed.model, prepared.roles.calibrate)
    found = []
    for chosen, base, least in (
        (prepared.judged, prepared.base, best),
        (fresh, judge(weighed, fresh, (), prepared.base.fit), judge(weighed, fresh, best.effects, best.fit)),
    ):
        independent = chosen.sum() / correlation_time(residual(weighed, best.fit)[chosen.any(1)])
        ratio = independent * max(base.left - least.left, 0.0) / least.left
        found.append(max(better(base.blocks, least.blocks), np.sqrt(ratio) / SELDOM))
    return found[0], found[1]


def _nothing(prepared: Prepared) -> str:
    """Whether the re-tune closes what is a gap by itself, or there was none."""
    left, blocks = left_of(prepared.weighed, prepared.judged, prepared.weighed.model.plain)
    tuned = left - prepared.base.left > prepared.weighed.least and better(blocks, prepared.base.blocks) > SIGNIFICANT
    return "parameters_only" if tuned else "no_significant_gap"


def _state(verdict: str, prepared: Prepared, state: Search, answers: Sequence[Answer], best: Stated) -> Verdict:
    model = prepared.weighed.model
    machine, record = model.machine, model.record
    simplest = of_one_size(candidates(machine, record))
    silent = {name: why for name in library() if (why := missing(name, machine, record)) and why != "it is no name"}
    return Verdict(
        machine=machine.name, joints=machine.joints, verdict=verdict, set=tuple(answers), parameters=best.parameters,
        gap=best.gap, where=tuple(where(prepared.weighed, prepared.base.fit)), not_observable=silent,
        detectable=detectable(machine, model.scales, state.seen, simplest, least=hidden(prepared, best.gap)),
        experiment=None,
        notes=(*poor(prepared), *at_bounds(prepared), *degenerate(answers)),
    )  # fmt: skip


def hidden(prepared: Prepared, gap: Gap) -> float:
    """Half squared distance on the fitted readings, in units of the noise, below which an effect counts for none, or may hide in what the
    best model leaves unexplained."""
    unexplained = prepared.weighed.model.mean * (gap.after**2 - gap.floor**2)
    return 0.5 * max(prepared.weighed.least, unexplained) * float(prepared.weighed.chosen.sum())


def answer_of(state: Search, weight: Weight, said: Stated | None) -> Answer:
    """An answer of a set. Of a law outside the library, `said` is what has a name beside it, if anything has."""
    effects, h = said.effects if said else (), weight.hypothesis
    return Answer(effects, weight.probability, weight.left, _forms(state, h) if h else {}, unknown=h is None)


def _forms(state: Search, answer: Hypothesis) -> dict[str, float]:
    """What each form of the names of an answer leaves of the gap."""
    gap = max(state.base.left - state.floor, 1e-12)
    same = sorted((h for h in state.tried if h.names == answer.names), key=lambda h: -h.left)
    return {" + ".join(c.form for c in h.effects): max(h.left - state.floor, 0.0) / gap for h in same}
