"""What a case's data could tell at best: everything that was tried, fitted to the noise-free truth, and how far it stays from it.

For the scorer, who has the answers: the right set is computed, not designed, and intervals are held against the library's own form of
the truth. Runs in a process of its own: python -m hamr_gap.bench.ideal OUT NUMBER
"""

from __future__ import annotations

import json
import sys
from dataclasses import asdict, replace
from itertools import product
from pathlib import Path

import numpy as np

import hidden_gap
from hamr_description.units import length_from_si
from hidden_gap.case import JOINTS, LEG, Case
from hidden_gap.noise import floors

from ..judging.stated import stated
from ..legs import machine_of, record_of
from ..naming.candidates import candidates
from ..naming.hypothesis import Hypothesis, refine, residual, settled, starts
from ..naming.prepare import Prepared, prepare
from ..naming.search import search
from ..naming.tried import Search
from .cases import case_of, recorded, samples_of

SHOWN = 8  # rivals that are written down, besides the re-tune
FORMS = 12  # of the right names that are fitted at most


def noise_free(case: Case) -> tuple[Prepared, Search, np.ndarray]:
    """A case as it would be solved if its sensors had no noise but were weighed by it, and that noise (channels,)."""
    truth = hidden_gap.simulate(case)
    record = record_of(samples_of(case, truth, truth, recorded(case, truth)), LEG, JOINTS)
    angle, tip = floors(case)
    noise = np.repeat([angle, length_from_si(tip)], 2)[: len(record.channels)]
    prepared = prepare(machine_of("simple", LEG), record, noise=noise)
    state = search(prepared.weighed, prepared.judged, prepared.base)
    return replace(prepared, base=state.base, weighed=state.weighed), state, noise  # perhaps better timed


def ideal(case: Case) -> dict:
    """d' of every set of names against the noise-free truth, and the right names' fits.

    Returns:
        rivals: [[effects], d'], least first; nothing is the re-tune alone, which is always among them.
        forms: of the right names, {form: parameters in SI}.
    """
    prepared, state, noise = noise_free(case)
    own = fits_of(prepared, state, truth_of(case))
    best: dict[frozenset, Hypothesis] = {}
    for h in sorted([prepared.base, *state.tried, *own], key=lambda h: h.left):
        best.setdefault(h.names, h)
    rivals = sorted(([said(h), _apart(prepared, h, noise)] for h in best.values()), key=lambda rival: rival[1])
    best_of = {h.effects: h for h in sorted(own, key=lambda h: -h.fit.cost)}  # of several fits of one form the best counts
    last = [settled(prepared.weighed, prepared.judged, h) for h in best_of.values()]
    forms = {" + ".join(c.form for c in h.effects): [asdict(e) for e in stated(prepared, h).effects] for h in last}
    return {"rivals": [rival for i, rival in enumerate(rivals) if i < SHOWN or not rival[0]], "forms": forms}


def said(h: Hypothesis) -> list:
    """[[family, form, [joints]]] of a hypothesis."""
    return [[c.effect, c.form, [JOINTS[j] for j in c.joints]] for c in h.effects]


def truth_of(case: Case) -> frozenset:
    """Names and places of what a case hides."""
    return frozenset((e.family, tuple(JOINTS.index(j) for j in e.joints)) for e in case.effects)


def fits_of(prepared: Prepared, state: Search, wanted: frozenset) -> list[Hypothesis]:
    """Fits of a set of names, in forms that the search tried and, if it tried none, in those that look best."""
    if tried := [h for h in state.tried if h.names == wanted]:
        return tried
    model = prepared.weighed.model
    forms = [[c for c in candidates(model.machine, model.record) if c.name == name] for name in wanted]
    look = state.seen
    seen = [(effects, look.solve([k for c in effects for k in look.best(c)[0].chosen])) for effects in product(*forms) if effects]
    found = sorted(starts(prepared.weighed, prepared.base.fit, look, seen), key=lambda start: start.cost)
    return [refine(prepared.weighed, prepared.judged, start) for start in found[:FORMS]]


def _apart(prepared: Prepared, h: Hypothesis, noise: np.ndarray) -> float:
    """d' of a fit against the noise-free truth: root of the squares that it leaves of all readings, in units of their noise."""
    weighed = prepared.weighed
    left = residual(weighed, h.fit) * weighed.sigma / (noise / np.sqrt(weighed.model.mean))
    return float(np.sqrt(np.nansum(left**2)))


if __name__ == "__main__":
    out, number = Path(sys.argv[1]), sys.argv[2]
    (out / "ideals").mkdir(exist_ok=True)
    (out / "ideals" / f"{number}.json").write_text(json.dumps(ideal(case_of(out / "answers" / f"{number}.json"))))
