"""A record prepared and, where it leaves a gap, searched.

In short runs where the re-tuned model's free ones go astray, unless what is found there mends these, and with the drive between its
samples as the re-tuned model has it, unless what is found there speaks for the other way.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np

from hamr_description.errors import BagError
from hamr_dynamics.machine import Machine

from ..data.record import Record
from .blocks import THROUGHOUT, better
from .candidates import candidates, of_one_size
from .hypothesis import Hypothesis, Start, left_of, refined
from .moves import look
from .prepare import Prepared, prepare
from .search import search
from .sensor_steps import staircases
from .tried import FLOOR_ERROR, Search, noise_floor


def searched(machine: Machine, record: Record, report: Callable[[str], None]) -> tuple[Prepared, Search]:
    """What a record is explained with, and all that was tried.

    Short runs start without the memory of what acts (a loop, a creep), and end before a slow effect shows. So where names that were
    found in them leave less in free ones, it was only for want of these names that free runs went astray, and all is searched again.
    So it is where as few effects leave less throughout of a drive that is smooth, instead of held, between samples, or the other way
    round: a model that lacks friction cannot tell, and half a sample would pass for a lag beside it.
    """
    report("re-tune")
    prepared, whole = prepare(machine, record), False
    state = gap_searched(prepared, report)
    if prepared.shortened and (mended := _mended(machine, record, prepared, state)):
        (prepared, known), whole = mended, True
        state = gap_searched(prepared, report, known)
    if state.best.effects and (mended := _otherwise(machine, record, prepared, state, whole=whole)):
        prepared, known = mended
        state = gap_searched(prepared, report, known)
    return replace(prepared, base=state.base, weighed=state.weighed), state


def gap_searched(prepared: Prepared, report: Callable[[str], None], known: Sequence[Start] = ()) -> Search:
    """What could be missing; nothing is tried where the re-tune leaves no gap.

    What is missing may look like noise beside the model, so no more counts as noise than the readings have. Steps of a sensor look like
    noise in the readings too, and are looked for.
    """
    weighed, judged, base = prepared.weighed, prepared.judged, prepared.base
    floor = noise_floor(weighed, base)
    noise = (1.0 - FLOOR_ERROR) * min(floor, 1.0)
    if base.left - noise > weighed.least or staircases(weighed, judged, base):
        return search(weighed, judged, base, report, known=known)
    report("screen")
    seen = look(weighed, base.fit, of_one_size(candidates(weighed.model.machine, weighed.model.record)))
    return Search(weighed, base, seen, int(judged.sum()), floor=floor)


def _mended(machine: Machine, record: Record, short: Prepared, state: Search) -> tuple[Prepared, list[Start]] | None:
    """The record in free runs, and the best of each number of effects as fitted in them, if one leaves less there."""
    try:
        whole = prepare(machine, record, whole=True)
        again = refined(whole.weighed, whole.judged, _starts(_by_number(state)))
    except BagError:  # diverges
        return None
    if min((_left(whole, h)[0] for h in again), default=np.inf) >= _left(short, state.best)[0]:
        return None
    return whole, _starts(again)


def _otherwise(
    machine: Machine, record: Record, before: Prepared, state: Search, *, whole: bool
) -> tuple[Prepared, list[Start]] | None:
    """The record with its drive the other way between samples, likewise, if that leaves less throughout. What runs freely needs none of
    that: its clock is shifted in the simulation; nor does a driver whose hold is known."""
    used = before.weighed.model
    if used.pieces is None or record.hold or record.drives_per_reading > 1 or not record.driven.any():
        return None
    try:
        other = prepare(machine, record, whole=whole, held=not used.record.held)
        if len(other.weighed.model.pieces or ()) != len(used.pieces):
            return None
        again = refined(other.weighed, other.judged, _starts(_by_number(state)))
    except BagError:  # diverges
        return None
    both = (before, _by_number(state)), (other, again)
    here, there = ({len(h.effects): _left(prepared, h)[1] for h in found if h.effects} for prepared, found in both)
    surely = (t for k in sorted(here.keys() & there.keys()) if abs(t := better(here[k], there[k])) > THROUGHOUT)
    return (other, _starts(again)) if next(surely, 0.0) > 0.0 else None


def _by_number(state: Search) -> list[Hypothesis]:
    """The best of each number of effects."""
    return list({len(h.effects): h for h in sorted(state.tried, key=lambda h: -h.left)}.values())


def _starts(found: Iterable[Hypothesis]) -> list[Start]:
    return [Start(h.effects, h.fit.free, h.fit.x, h.fit.cost) for h in found]


def _left(prepared: Prepared, h: Hypothesis) -> tuple[float, np.ndarray]:
    """Mean square on the judged readings, and (b,) of each block, in units of a sample's noise: what counts as that of a reading may
    differ."""
    return left_of(replace(prepared.weighed, sigma=prepared.noise), prepared.judged, h.fit.reading)
