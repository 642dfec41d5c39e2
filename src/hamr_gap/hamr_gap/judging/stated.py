"""What a hypothesis says outside: effects, parameter changes and gaps in SI with intervals, and what to know besides."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hamr_dynamics.effects.library import library
from hamr_dynamics.machine import CHANGES

from ..data.si import channel_si, si_of
from ..fitting.parameters import Candidate
from ..naming.hypothesis import Hypothesis, residual
from ..naming.prepare import Prepared
from .interval import intervals
from .verdict import Answer, Estimate, Gap, NamedEffect


@dataclass(frozen=True)
class Stated:
    """A hypothesis in SI: its effects, its parameter changes (name -> joint -> change), and the gap with it."""

    effects: tuple[NamedEffect, ...]
    parameters: dict[str, dict[str, Estimate]]
    gap: Gap


def stated(prepared: Prepared, h: Hypothesis) -> Stated:
    """A hypothesis with intervals, and the gap it leaves on the judged readings."""
    machine, scales = prepared.weighed.model.machine, prepared.weighed.model.scales
    each = zip(h.fit.free, h.fit.x, intervals(prepared.weighed, h.fit), strict=True)
    found = {f.row: np.array([x, *bounds]) for f, x, bounds in each}

    def estimate(row: str, dimension: str) -> Estimate:
        factor, unit = si_of(dimension, machine)
        return Estimate(*(found[row] * factor * scales.of(dimension)).tolist(), unit)

    def effect(c: Candidate) -> NamedEffect:
        parameters: dict[str, dict[str, Estimate]] = {}
        for place in c.places:
            where = machine.joints[place] if c.law.acts != "pair" else "both"
            for p in c.law.parameters:
                parameters.setdefault(p.name, {})[where] = estimate(c.row(p, place), p.dimension)
        return NamedEffect(c.effect, c.form, tuple(machine.joints[j] for j in c.joints), parameters)

    changes: dict[str, dict[str, Estimate]] = {}
    for row in found:
        if row.startswith("change."):
            _, name, joint = row.split(".")
            changes.setdefault(name, {})[machine.joints[int(joint)]] = estimate(row, CHANGES[name])
    return Stated(tuple(effect(c) for c in h.effects), changes, _gap_of(prepared, h))


def _gap_of(prepared: Prepared, best: Hypothesis) -> Gap:
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


def poor(prepared: Prepared) -> list[str]:
    """What is poor about the data."""
    record = prepared.weighed.model.record
    stale, uneven, shaken = (100 * share for share in (prepared.stale, record.uneven, record.shaken))
    said = {
        f"{stale:.2g} % of the samples repeat the one before in every sensor and were left out.": stale,
        f"Measured at times uneven by up to {uneven:.2g} % of a step: what was used are curves through the samples, at even ones.": uneven,
        f"{shaken:.2g} % of the samples, just after an actuator met its end stop, were left out: what acts only then is not seen.": shaken,
    }
    return [sentence for sentence, much in said.items() if much]


def degenerate(answers: Sequence[Answer]) -> tuple[str, ...]:
    """What the names of an answer cannot be told from, and when."""
    named = dict.fromkeys(e.effect for answer in answers for e in answer.effects)
    same = ((name, other, when) for name in named for other, when in library()[name].same_as.items())
    return tuple(f"{name} is the same as {other} {when}." for name, other, when in same)


def at_bounds(prepared: Prepared) -> list[str]:
    """Which parameters a re-tune would rather have beyond their bounds: what is missing may hide in these."""
    machine, least = prepared.weighed.model.machine, []
    for f, x in zip(prepared.base.fit.free, prepared.base.fit.x, strict=True):
        if f.row.startswith("change.") and x <= f.low:
            _, name, joint = f.row.split(".")
            least.append(f"{name} of {machine.joints[int(joint)]}")
    return [f"Re-tuned alone, the model would have as little as it may of: {', '.join(least)}."] if least else []
