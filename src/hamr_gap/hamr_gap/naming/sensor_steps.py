"""Sensors with coarse steps: where a hypothesis leaves a staircase, and the hypothesis with it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..data.readings import rounding
from ..fitting.fit import Fit
from ..fitting.parameters import Candidate, Free, effect_parameters
from ..fitting.sensors import Sensors, late
from ..fitting.weighed import Weighed
from .hypothesis import Hypothesis, judge, residual
from .staircase import Staircase, staircase

STEPPED = 0.8  # of what is left of a sensor, that must be left at most with its steps


def staircases(weighed: Weighed, judged: np.ndarray, h: Hypothesis) -> dict[int, Staircase]:
    """Joint -> its sensor's steps, where they show beside a hypothesis and it leaves less of that sensor with them."""
    if not (seen := _seen(weighed, h.fit)):
        return {}
    each = (residual(weighed, x.fit) for x in (h, with_stairs(weighed, judged, h, seen)))
    before, after = (np.nanmean(np.where(judged, left**2, np.nan), axis=0) for left in each)
    gone = after < STEPPED * before
    return {own: steps for own, steps in seen.items() if gone[weighed.model.own.index(own)]}


def _seen(weighed: Weighed, found: Fit) -> dict[int, Staircase]:
    """Joint -> steps that show beside a fit; sensors whose readings are multiples of a step have no secret."""
    model, record = weighed.model, weighed.model.record
    each = replace(model, mean=1)
    run = late(each.runs(found.free, found.x)[0], found.sensors.shift, record.step, each.starts)
    left = record.readings - ((1.0 + found.sensors.gain) * run + found.sensors.bias)
    seen = {}
    for c, own in enumerate(model.own):
        if own < len(model.machine.joints) and rounding(record.readings[:, c]) == 0.0:
            known = np.isfinite(left[:, c])
            if stairs := staircase(run[known, c], left[known, c]):
                seen[own] = stairs
    return seen


def with_stairs(weighed: Weighed, judged: np.ndarray, h: Hypothesis, stairs: dict[int, Staircase]) -> Hypothesis:
    """A hypothesis with the steps of some sensors besides; nothing else is fitted anew, for steps move nothing on the average."""
    form = "hysteresis" if any(s.stick for s in stairs.values()) else "rounding"
    effect = Candidate("sensor_quantisation", form, tuple(sorted(stairs)))
    pinned = [_pinned(free, stairs[int(free.row.rsplit(".", 1)[1])]) for free in effect_parameters([effect], weighed.model.scales)]
    return judge(weighed, judged, (*h.effects, effect), _read(weighed, h.fit, pinned))


def _pinned(free: Free, stairs: Staircase) -> Free:
    """A parameter that stays where it was found."""
    name = free.row.split(".")[2]
    x, sd = {"step": (stairs.step, stairs.spread), "offset": (stairs.offset, 0.1 * stairs.step), "stick": (stairs.stick, 0.1)}[name]
    return replace(free, low=x / free.scale, high=x / free.scale, center=x / free.scale, sd=sd / free.scale)


def _read(weighed: Weighed, found: Fit, pinned: Sequence[Free]) -> Fit:
    """A fit with pinned parameters besides, its sensors solved for anew."""
    free, x = (*found.free, *pinned), np.append(found.x, [f.center for f in pinned])
    run = weighed.model.runs(free, x)[0]
    s, cost = weighed.solve_sensors(run[: weighed.until], found.sensors.shift)
    sensors: Sensors = weighed.sensors(s)
    reading = sensors.read(run, weighed.model.reading_step, weighed.model.starts)
    return Fit(free, x, sensors, run, reading, cost)
