"""A record prepared and searched: in short runs where the re-tuned model's free ones go astray, unless what is found there mends these."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np

from hamr_description.errors import BagError
from hamr_dynamics.machine import Machine

from .hypothesis import Hypothesis, Start, left_of, refined
from .prepare import Prepared, prepare
from .record import Record
from .search import Search, search


def searched(machine: Machine, record: Record, report: Callable[[str], None]) -> tuple[Prepared, Search]:
    """What a record is explained with, and all that was tried.

    Short runs start without the memory of what acts (a loop, a creep), and end before a slow effect shows. So where names that were
    found in them leave less in free ones, it was only for want of these names that free runs went astray, and all is searched again.
    """
    report("re-tune")
    prepared = prepare(machine, record)
    state = search(prepared.weighed, prepared.judged, prepared.base, report)
    if prepared.shortened and (mended := _mended(machine, record, prepared, state)):
        prepared, known = mended
        state = search(prepared.weighed, prepared.judged, prepared.base, report, known=known)
    return replace(prepared, base=state.base, weighed=state.weighed), state


def _mended(machine: Machine, record: Record, short: Prepared, state: Search) -> tuple[Prepared, list[Start]] | None:
    """The record in free runs, and the best of each number of effects as fitted in them, if one leaves less there."""
    best = {len(h.effects): h for h in sorted(state.tried, key=lambda h: -h.left)}
    try:
        whole = prepare(machine, record, whole=True)
        again = refined(whole.weighed, whole.judged, _starts(best.values()))
    except BagError:  # diverges
        return None
    if min((_left(whole, h) for h in again), default=np.inf) >= _left(short, state.best):
        return None
    return whole, _starts(again)


def _starts(found: Iterable[Hypothesis]) -> list[Start]:
    return [Start(h.effects, h.fit.free, h.fit.x, h.fit.cost) for h in found]


def _left(prepared: Prepared, h: Hypothesis) -> float:
    """Mean square on the judged readings, in units of a sample's noise: what counts as noise of a reading may differ."""
    return left_of(replace(prepared.weighed, sigma=prepared.noise), prepared.judged, h.fit.reading)[0]
