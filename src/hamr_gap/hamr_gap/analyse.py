"""Find and name, for one machine: from a record to a verdict."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from hamr_dynamics.effects.library import library
from hamr_dynamics.machine import CHANGES, Machine

from .blocks import better
from .candidates import missing
from .colour import correlation_time
from .detect import detectable
from .fit import Fit
from .hypothesis import Hypothesis, judge, left_of, residual
from .interval import intervals
from .parameters import Candidate
from .prepare import Prepared
from .record import Record
from .roles import mask
from .search import Search, noise_floor
from .searched import searched
from .si import channel_si, si_of
from .unexplained import structural
from .verdict import Answer, Estimate, Gap, NamedEffect, Verdict
from .weigh import Weight, credible, weigh
from .where import where

SIGNIFICANT = 4.5  # t over blocks on the readings that selected, with many names tried
CONFIRMED = 2.0  # t over blocks on readings that nothing has seen
SMALLEST = 0.25  # rms in noise of a sample: a gap below it is none, whatever its significance
SHARE = 0.25  # of a gap, that the best of all names must explain, or the gap has another cause
SELDOM = 2.0  # how many times surer a likelihood ratio must be, which trusts its noise, than t over blocks, which does not


@dataclass(frozen=True)
class Analysis:
    """A verdict and all that led to it, for reports."""

    prepared: Prepared
    search: Search
    weights: list[Weight]
    best: Hypothesis
    verdict: Verdict
    evidence: tuple[float, float]

    def left(self, part: np.ndarray) -> dict[str, float]:
        """Mean squares, in units of the noise, that the re-tune and the best hypothesis leave on a role, and what noise alone leaves."""
        weighed = self.prepared.weighed
        rows = mask(weighed.model, part)
        base, best = (judge(weighed, rows, (), h.fit).left for h in (self.prepared.base, self.best))
        return {"base": base, "best": best, "floor": noise_floor(weighed, judge(weighed, rows, (), self.best.fit))}


def analyse(machine: Machine, record: Record, report: Callable[[str], None] = lambda _: None) -> Analysis:
    """Finds the gap between a machine's model and a record of it, and names what is missing.

    Raises:
        BagError: the record cannot be used; one sentence.
    """
    prepared, state = searched(machine, record, report)
    least = prepared.weighed.model.mean * max(SMALLEST, 0.5 * prepared.weighed.numerical) ** 2
    weights = weigh(state, int(prepared.judged.sum()), least)
    evidence = _evidence(prepared, state)
    explained = prepared.base.left - state.best.left
    named = explained > max(least, SHARE * (prepared.base.left - state.floor)) and evidence[0] > SIGNIFICANT and evidence[1] > CONFIRMED
    if not named and structural(prepared.weighed, prepared.judged, prepared.base.fit):
        verdict, best, chosen = "unknown", state.best, [Weight(None, 1.0, 1.0)]
    elif not named:
        verdict, best, chosen = _nothing(prepared), prepared.base, []
    else:
        chosen = credible(weights)
        best = next((w.hypothesis for w in weights if w.hypothesis is not None), state.best)
        verdict = "unknown" if chosen[0].hypothesis is None else "named" if len(chosen) == 1 else "ambiguous"
    report("intervals")
    return Analysis(prepared, state, weights, best, _state(verdict, prepared, state, chosen, best), evidence)


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
    _, blocks = left_of(prepared.weighed, prepared.judged, prepared.weighed.model.plain)
    return "parameters_only" if better(blocks, prepared.base.blocks) > SIGNIFICANT else "no_significant_gap"


def _state(verdict: str, prepared: Prepared, state: Search, chosen: list[Weight], best: Hypothesis) -> Verdict:
    model = prepared.weighed.model
    machine, record = model.machine, model.record
    least = 0.5 * model.mean * SMALLEST**2 * float(prepared.weighed.chosen.sum())
    answers = tuple(
        Answer(effects_of(prepared, w.hypothesis), w.probability, w.left, _forms(state, w.hypothesis)) if w.hypothesis
        else Answer((), w.probability, w.left) for w in chosen
    )  # fmt: skip
    silent = {name: why for name in library() if (why := missing(name, machine, record)) and why != "it is no name"}
    return Verdict(
        machine=machine.name, joints=machine.joints, verdict=verdict, set=answers, parameters=changes_of(prepared, best.fit),
        gap=gap_of(prepared, best), where=tuple(where(prepared.weighed, prepared.base.fit)), not_observable=silent,
        detectable=detectable(machine, model.scales, state.seen, least=least), experiment=None,
        notes=(*_poor(prepared), *degenerate(answers)),
    )  # fmt: skip


def _poor(prepared: Prepared) -> list[str]:
    """What is poor about the data."""
    stale, uneven = 100 * prepared.stale, 100 * prepared.weighed.model.record.uneven
    said = {
        f"{stale:.2g} % of the samples repeat the one before in every sensor and were left out.": stale,
        f"Measured at times uneven by up to {uneven:.0f} % of a step: what was used are curves through the samples, at even ones.": uneven,
    }
    return [sentence for sentence, much in said.items() if much]


def degenerate(answers: Sequence[Answer]) -> tuple[str, ...]:
    """What the names of an answer cannot be told from, and when."""
    named = dict.fromkeys(e.effect for answer in answers for e in answer.effects)
    same = ((name, other, when) for name in named for other, when in (library()[name].same_as or {}).items())
    return tuple(f"{name} is the same as {other} {when}." for name, other, when in same)


def _forms(state: Search, answer: Hypothesis) -> dict[str, float]:
    """What each form of the names of an answer leaves of the gap."""
    gap = max(state.base.left - state.floor, 1e-12)
    same = sorted((h for h in state.tried if h.names == answer.names), key=lambda h: -h.left)
    return {" + ".join(c.form for c in h.effects): max(h.left - state.floor, 0.0) / gap for h in same}


def effects_of(prepared: Prepared, h: Hypothesis) -> tuple[NamedEffect, ...]:
    """A hypothesis' effects with their parameters in SI."""
    machine = prepared.weighed.model.machine
    bounds = dict(zip((f.row for f in h.fit.free), intervals(prepared.weighed, h.fit), strict=True))
    values = dict(zip((f.row for f in h.fit.free), h.fit.x, strict=True))
    scales = prepared.weighed.model.scales

    def effect(c: Candidate) -> NamedEffect:
        parameters: dict[str, dict[str, Estimate]] = {}
        for place in c.places:
            where_ = machine.joints[place] if c.law.acts != "pair" else "both"
            for p in c.law.parameters:
                row = c.row(p, place)
                factor, unit = si_of(p.dimension, machine)
                factor *= scales.of(p.dimension)
                low, high = bounds[row]
                parameters.setdefault(p.name, {})[where_] = Estimate(values[row] * factor, low * factor, high * factor, unit)
        return NamedEffect(c.effect, c.form, tuple(machine.joints[j] for j in c.joints), parameters)

    return tuple(effect(c) for c in h.effects)


def changes_of(prepared: Prepared, found: Fit) -> dict[str, dict[str, Estimate]]:
    """A fit's parameter changes in SI."""
    machine, scales = prepared.weighed.model.machine, prepared.weighed.model.scales
    bounds = intervals(prepared.weighed, found)
    result: dict[str, dict[str, Estimate]] = {}
    for f, x, (low, high) in zip(found.free, found.x, bounds, strict=True):
        if f.row.startswith("change."):
            _, name, joint = f.row.split(".")
            factor, unit = si_of(CHANGES[name], machine)
            factor *= scales.of(CHANGES[name])
            result.setdefault(name, {})[machine.joints[int(joint)]] = Estimate(x * factor, low * factor, high * factor, unit)
    return result


def gap_of(prepared: Prepared, best: Hypothesis) -> Gap:
    """Gaps on the judged readings, in noise of one sample; per channel in SI."""
    weighed = prepared.weighed
    model, mean = weighed.model, weighed.model.mean
    three = {"raw": weighed.left(model.plain), "retuned": residual(weighed, prepared.base.fit), "after": residual(weighed, best.fit)}
    chosen = prepared.judged.any(1)
    totals = {name: float(np.sqrt(np.nanmean(x[chosen] ** 2) / mean)) for name, x in three.items()}
    channels = {
        channel: {
            name: float(np.sqrt(np.nanmean(x[chosen, c] ** 2)) * weighed.sigma[c] * channel_si(model.machine, channel)[0])
            for name, x in three.items()
        }
        for c, channel in enumerate(model.record.channels)
    }
    return Gap(**totals, floor=float(np.hypot(1.0, prepared.weighed.numerical)), per_channel=channels)
