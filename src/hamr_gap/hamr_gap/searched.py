"""A record prepared and searched: in short runs where the re-tuned model's free ones go astray, unless what is found there mends these."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from hamr_description.errors import BagError
from hamr_dynamics.machine import Machine

from .hypothesis import Hypothesis, Start, refined, residual
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
    if prepared.shortened and state.tried:
        known = [Start(h.effects, h.fit.free, h.fit.x, np.inf) for h in (state.best_of(1), state.best)]
        if whole := _mended(machine, record, known, _left(prepared, state.best)):
            prepared, state = whole, search(whole.weighed, whole.judged, whole.base, report, known=known)
    return replace(prepared, base=state.base, weighed=state.weighed), state


def _mended(machine: Machine, record: Record, known: Sequence[Start], left: float) -> Prepared | None:
    """The record in free runs, if some of the known effects leave less in them."""
    try:
        whole = prepare(machine, record, whole=True)
        again = refined(whole.weighed, whole.judged, known)
    except BagError:  # diverges
        return None
    return whole if min(_left(whole, h) for h in again) < left else None


def _left(prepared: Prepared, h: Hypothesis) -> float:
    """Mean square on the judged readings, in units of a sample's noise: what counts as noise of a reading may differ."""
    left = residual(prepared.weighed, h.fit) * prepared.weighed.sigma / prepared.noise
    return float(np.nanmean(np.where(prepared.judged, left, np.nan) ** 2))
