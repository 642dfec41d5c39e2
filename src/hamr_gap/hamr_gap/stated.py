"""What a hypothesis says outside: effects, parameter changes and gaps in SI with intervals, and what to know besides."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hamr_dynamics.effects.library import library
from hamr_dynamics.machine import CHANGES

from .fit import Fit
from .hypothesis import Hypothesis, residual
from .interval import intervals
from .parameters import Candidate
from .prepare import Prepared
from .si import channel_si, si_of
from .verdict import Answer, Estimate, Gap, NamedEffect


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


def poor(prepared: Prepared) -> list[str]:
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
