"""Which single effects are fitted for good: what simulated first steps like about the re-tuned model, about the one as given, and in short
pieces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..fitting.fit import fit
from ..fitting.parameters import Candidate
from ..fitting.weighed import Weighed
from .hypothesis import Hypothesis, Start
from .moves import ALONE, first_families, first_of_each, in_forms, look, promising, singles
from .screen import Screen

SINGLES, FAMILIES = 10, 6  # names fitted for good, and effects, however many places of others come before them
ALL_FORMS = 3  # of these, in all their forms
GIVEN = 4  # names that the model as given likes best, fitted besides
ASTRAY = 10.0  # times the re-tune's cost, up to which the model as given is worth looking about: beyond, other parameters are what it lacks
LOST = 0.1  # of a sensor's motion, that a free run must be off by for names to be looked for in short pieces too


def single_starts(
    weighed: Weighed, judged: np.ndarray, base: Hypothesis, seen: Screen, everything: Sequence[Candidate]
) -> tuple[list[Start], list[Start]]:
    """Starts of single effects, about the re-tuned model and the one as given, and those to fit for good."""
    found = singles(weighed, base.fit, seen, everything)
    given, liked = fit(weighed, base.fit.free, np.zeros(len(base.fit.free)), steps=0), []
    if given.cost < ASTRAY * base.fit.cost:  # a strong effect leads the re-tune astray
        found += (liked := singles(weighed, given, look(weighed, given, everything, like=base.fit, before=seen), everything))
    near = promising(found, ALONE)
    wanted = in_forms(single_names(near), near, ALL_FORMS)
    wanted += _by_pieces(weighed, judged, base, everything)
    names = {start.effects[0].name for start in wanted}  # what the model as given likes costs more before it is re-tuned
    return found, [*wanted, *(start for start in first_of_each(liked, GIVEN) if start.effects[0].name not in names)]


def _by_pieces(weighed: Weighed, judged: np.ndarray, base: Hypothesis, everything: Sequence[Candidate]) -> list[Start]:
    """Starts of the single effects that short pieces like best, to fit for good where a free run is far from what was measured: about
    one that is lost nothing is linear."""
    motion = np.nanstd(weighed.model.target, axis=0) / weighed.sigma
    seen = replace(weighed, chosen=weighed.chosen | judged)
    if weighed.model.starts or (seen.missed(base.fit.reading) < LOST * motion).all():
        return []
    short = weighed.in_pieces
    about = fit(short, base.fit.free, base.fit.x)
    near = promising(singles(short, about, look(short, about, everything), everything), ALONE)
    return in_forms(single_names(near), near, ALL_FORMS)


def single_names(near: Sequence[Start]) -> list[Start]:
    """Starts of the names that leave least: so many names and so many effects at least."""
    return max(first_of_each(near, SINGLES), first_families(near, FAMILIES), key=len)
