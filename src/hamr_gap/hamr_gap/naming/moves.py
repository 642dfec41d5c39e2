"""Moves of the search that add: every candidate alone, pairs in the linear picture, one more beside others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from hamr_dynamics.effects.library import library

from ..fitting.fit import Fit
from ..fitting.parameters import Candidate, effect_parameters
from ..fitting.weighed import Weighed
from .hypothesis import Hypothesis, Start, refine, refined, residual, starts
from .screen import Screen, screen
from .sought import sought
from .tried import Search

LIKED = 24  # names simulated alone: those that leave little then stand high in the linear picture about a re-tune
SHAPES = 2  # sets of shapes of each candidate that are simulated
FOLLOWED = 12  # of the one that explains most, if it has more
ALIKE = 1.5  # times the least cost, up to which fewer places explain as much
PAIRS_SEEN, PAIRS = 60, 5  # pairs simulated, and fitted
ALONE, PROMISING = 20.0, 3.0  # times the cost of the best start, from which one effect, or a larger set, is fitted at all
MORE = 6  # effects fitted beside others
NAMES = 3  # single ones that are fitted from all their starts where more than one seems to be missing


def look(weighed: Weighed, about: Fit, wanted: Sequence[Candidate], *, like: Fit | None = None, before: Screen | None = None) -> Screen:
    """The linear picture about a fit, of responses about as large as what a fit (that one, if not another) leaves.

    Args:
        before: as of `screen`.
    """
    left = residual(weighed, like or about)[weighed.chosen]
    return screen(weighed, about, wanted, amplitude=float(np.sqrt(np.mean(left**2))), before=before)


def singles(weighed: Weighed, about: Fit, seen: Screen, wanted: Sequence[Candidate]) -> list[Start]:
    """A start for each of the names that the linear picture likes best, in all forms and their best shapes."""
    solutions = sorted(((c, s) for c in wanted for s in seen.best(c, SHAPES)), key=lambda found: found[1].cost)
    names = list(dict.fromkeys(c.name for c, _ in solutions))[:LIKED]
    return starts(weighed, about, seen, [((c,), s) for c, s in solutions if c.name in names])


def first_of_each(found: Sequence[Start], count: int) -> list[Start]:
    """The starts that leave least, one for each set of names."""
    best: dict[frozenset, Start] = {}
    for start in sorted(found, key=lambda s: s.cost):
        best.setdefault(_names(start), start)
    return list(best.values())[:count]


def first_families(found: Sequence[Start], count: int) -> list[Start]:
    """The same for so many effects, at all places that come before the last of these: places of one effect crowd no other out."""
    kept, effects = [], set()
    for start in first_of_each(found, len(found)):
        effects.add(start.effects[0].effect)
        if len(effects) > count:
            break
        kept.append(start)
    return kept


def in_forms(first: Sequence[Start], found: Sequence[Start], forms: int) -> list[Start]:
    """Starts of names, the very first of them in every form found: all forms of a name come before a second name."""
    every = {_names(s) for s in first[:forms]}
    best: dict[Candidate, Start] = {}
    for start in sorted(found, key=lambda s: s.cost):
        if _names(start) in every:
            best.setdefault(start.effects[0], start)
    return [*best.values(), *first[forms:]]


def pairs_of(
    weighed: Weighed, judged: np.ndarray, state: Search, everything: Sequence[Candidate], alone: Sequence[Start],
) -> list[Hypothesis]:  # fmt: skip
    """All pairs in the linear picture, since a pair can explain what neither of its members does; the best simulated, then fitted.

    Of each name the form whose start, `alone`, left least, or what the linear picture likes best.
    """
    seen, about = state.seen, state.base.fit
    best = {c: seen.best(c)[0] for c in everything}
    simulated = [start.effects[0] for start in first_of_each(alone, len(alone))]
    form: dict[tuple, Candidate] = {}
    for c in (*simulated, *sorted(everything, key=lambda c: best[c].cost)):
        form.setdefault(c.name, c)
    kept = form.values()
    pairs = {(a, b): seen.solve((*best[a].chosen, *best[b].chosen)) for a, b in combinations(kept, 2) if apart(a, b)}
    wanted = sorted(pairs.items(), key=lambda pair: pair[1].cost)[:PAIRS_SEEN]
    return sought(weighed, judged, promising(first_of_each(starts(weighed, about, seen, wanted), PAIRS)), rough=state.rough)


def apart(a: Candidate, b: Candidate) -> bool:
    """Whether two effects may stand beside each other: other names, neither of which has the other as a special case at a joint."""
    return a.effect != b.effect and not (set(a.joints) & set(b.joints) and (_holds(a, b) or _holds(b, a)))


def _holds(wide: Candidate, simple: Candidate) -> bool:
    """Whether one has the other as a special case; what acts on one joint by itself holds nothing that couples two."""
    return simple.effect in library()[wide.effect].contains and (wide.law.acts == "pair" or simple.law.acts != "pair")


def beside(
    weighed: Weighed, judged: np.ndarray, state: Search, others: Hypothesis, everything: Sequence[Candidate],
) -> list[Hypothesis]:  # fmt: skip
    """One more effect beside others, in a linear picture about them; the first name in all its forms."""
    wanted = [c for c in everything if all(apart(c, e) for e in others.effects)]
    found = promising(singles(weighed, others.fit, look(weighed, others.fit, wanted, before=state.seen), wanted))
    added = sought(weighed, judged, in_forms(first_families(found, MORE), found, 1), [state.best], rough=state.rough)
    fitted = [replace(h, effects=(*others.effects, *h.effects)) for h in added]
    return [*fitted, *at_both(weighed, judged, fitted)]


def at_both(weighed: Weighed, judged: np.ndarray, found: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Last effects with a threshold, found at each joint by itself, together from there: no screen knows two thresholds that differ."""
    best: dict[tuple[str, str], dict[int, Hypothesis]] = {}
    for h in sorted(found, key=lambda h: -h.left):
        c = h.effects[-1]
        if len(c.places) == 1 and c.law.acts != "pair" and any(p.screen for p in c.law.sizes):
            best.setdefault((c.effect, c.form), {})[c.joints[0]] = h
    pairs = [tuple(at.values()) for at in best.values() if len(at) == 2]
    return [_together(weighed, judged, *sorted(pair, key=lambda h: h.left)) for pair in pairs]


def _together(weighed: Weighed, judged: np.ndarray, h: Hypothesis, other: Hypothesis) -> Hypothesis:
    """Two hypotheses with one effect at a joint each, as one with it at both."""
    own, added = h.effects[-1], other.effects[-1]
    rows = {f.row for f in effect_parameters((added,), weighed.model.scales)}
    more = [(f, x) for f, x in zip(other.fit.free, other.fit.x, strict=True) if f.row in rows]
    effects = (*h.effects[:-1], replace(own, joints=tuple(sorted((*own.joints, *added.joints)))))
    free, x = (*h.fit.free, *(f for f, _ in more)), np.array([*h.fit.x, *(x for _, x in more)])
    return refine(weighed, judged, Start(effects, free, x, np.inf))


def from_elsewhere(weighed: Weighed, judged: np.ndarray, alone: Sequence[Start], tried: Sequence[Hypothesis]) -> list[Hypothesis]:
    """The single effects that leave least, from all their starts, `alone`, that were not fitted: other forms, and shapes that began worse.

    A soft place's fit from the wrong side of its middle ends where two other effects leave less.
    """
    names = list(dict.fromkeys(h.effects[0].name for h in sorted(tried, key=lambda h: h.left) if len(h.effects) == 1))[:NAMES]
    fitted, wanted = {h.effects for h in tried}, []
    for start in sorted(alone, key=lambda s: s.cost):
        if start.effects in fitted:
            fitted.discard(start.effects)  # the best of its starts has been
        elif start.effects[0].name in names:
            wanted.append(start)
    return refined(weighed, judged, wanted, [min(tried, key=lambda h: h.left)])


def in_other_shapes(weighed: Weighed, judged: np.ndarray, about: Fit, seen: Screen, tried: Sequence[Hypothesis]) -> list[Hypothesis]:
    """The single effect that comes nearest to the fitted readings, from more of its shapes, if there are many.

    Waves of other periods pass through the few stretches that are fitted nearly as well: fits rest at any of them.
    """
    near = min(h.fit.cost for h in tried) * ALIKE
    c = min((h for h in tried if h.fit.cost <= near), key=lambda h: (len(h.effects[0].places), h.fit.cost)).effects[0]
    if len(seen.options(c)) <= FOLLOWED:
        return []
    distinct = {round(s.cost, 6): s for s in seen.best(c, 2 * FOLLOWED)}  # two waves may change places
    wanted = [((c,), s) for s in list(distinct.values())[:FOLLOWED]]
    return refined(weighed, judged, starts(weighed, about, seen, wanted))


def promising(found: Sequence[Start], times: float = PROMISING) -> list[Start]:
    """Those whose starts are not far worse than the best."""
    least = min((start.cost for start in found), default=0.0)
    return [start for start in found if start.cost <= times * least]


def _names(start: Start) -> frozenset:
    return frozenset(c.name for c in start.effects)
