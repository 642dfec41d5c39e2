"""A law that is not in the library, as a table: force over angle and rate, or drive over drive, at the joint where it explains most."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hamr_dynamics.effects.library import library

from ..fitting.parameters import Candidate
from ..naming.hypothesis import Hypothesis, refined, residual, starts
from ..naming.prepare import Prepared
from ..naming.screen import screen

TABLE = "force_table"
FITTED = 4  # tables fitted for good
SHAPES = 4  # sets of widths of each that are simulated


def fit_table(prepared: Prepared, beside: Hypothesis) -> Hypothesis:
    """The table that, beside a hypothesis, leaves least of the gap on the judged readings."""
    weighed, base = prepared.weighed, beside.fit
    joints = range(len(weighed.model.machine.joints))
    tables = [Candidate(TABLE, form.name, (j,)) for form in library()[TABLE].forms for j in joints]
    amplitude = float(np.sqrt(np.mean(residual(weighed, base)[weighed.chosen] ** 2)))
    seen = screen(weighed, base, tables, amplitude=amplitude)
    first = sorted(starts(weighed, base, seen, [((c,), s) for c in tables for s in seen.best(c, SHAPES)]), key=lambda s: s.cost)
    best = min(refined(weighed, prepared.judged, first[:FITTED]), key=lambda h: h.left)
    return replace(best, effects=(*beside.effects, *best.effects))
