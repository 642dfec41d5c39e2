"""Moves of the search that take away or put in the place of: an effect less, at one joint less, or what another name does as well."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import permutations

import numpy as np

from hamr_dynamics.effects.law import Form, Parameter
from hamr_dynamics.effects.library import library

from ..fitting.fit import Fit, fit
from ..fitting.parameters import Candidate, effect_parameters
from ..fitting.weighed import Weighed
from .candidates import candidates
from .hypothesis import Hypothesis, Start, refine, refined

LITTLE = 1e-3  # of its prior, at which a size begins of which nothing is known
HARMLESS = 1.1  # times what was left before


def without(weighed: Weighed, judged: np.ndarray, h: Hypothesis, effect: Candidate) -> Hypothesis:
    """A hypothesis fitted again without one of its effects."""
    return refine(weighed, judged, _less(h, tuple(c for c in h.effects if c != effect)))


def bare(weighed: Weighed, h: Hypothesis) -> Fit:
    """The re-tune that was found with effects, without them."""
    alone = _less(h, ())
    return fit(weighed, alone.free, alone.x, steps=0)


def narrowed(weighed: Weighed, judged: np.ndarray, h: Hypothesis) -> list[Hypothesis]:
    """A hypothesis fitted again without one of its effects, or with it at one joint instead of two; and on, while that does no harm."""
    wanted = []
    for i, c in enumerate(h.effects):
        fewer = [*_at_one(c), *[()] * (len(h.effects) > 1)]
        wanted += [_less(h, (*h.effects[:i], *some, *h.effects[i + 1 :])) for some in fewer]
    found = refined(weighed, judged, wanted)
    best = min(found, key=lambda n: n.left, default=None)
    return [*found, *narrowed(weighed, judged, best)] if best and best.left < HARMLESS * h.left else found


def as_narrow(weighed: Weighed, judged: np.ndarray, tried: Sequence[Hypothesis]) -> list[Hypothesis]:
    """What does as well as the best, but at two joints, fitted again at the one where another does: a simpler form may be among them."""
    known: dict[tuple[Candidate, ...], Hypothesis] = {}
    for h in sorted(tried, key=lambda h: h.left):
        known.setdefault(h.effects, h)
    least = min((h.left for h in tried), default=0.0)
    near = [h for h in known.values() if h.left < HARMLESS * least]
    places = {tuple(c.places for c in h.effects) for h in near}
    fewer = {(*h.effects[:i], *some, *h.effects[i + 1 :]): h for h in near for i, c in enumerate(h.effects) for some in _at_one(c)}
    return refined(weighed, judged, [_less(h, to) for to, h in fewer.items() if to not in known and tuple(c.places for c in to) in places])


def _at_one(c: Candidate) -> list[tuple[Candidate]]:
    """An effect of two joints at each of them."""
    return [(replace(c, joints=(joint,)),) for joint in c.places if len(c.places) > 1]


def special_cases(weighed: Weighed, judged: np.ndarray, h: Hypothesis) -> list[Hypothesis]:
    """A hypothesis fitted again with another name, in all its forms, in the place of one that contains or mimics it, or is the same to
    some sensors.

    Of several effects each is fitted in its own other forms too: singles have been, but others were found beside some one form. So is
    one that couples two joints: it may be a form of its own name at one of them, which a fit from elsewhere has missed. What stands at
    both joints may be needed at one of them alone, and a special case of it suffice at the other.
    """
    values = dict(zip((f.row for f in h.fit.free), h.fit.x, strict=True))
    retuned = [f for f in h.fit.free if f.row.startswith("change.")]
    wanted, possible = [], set(candidates(weighed.model.machine, weighed.model.record))
    for i, c in enumerate(h.effects):
        for some in _in_place_of(c, alone=len(h.effects) == 1):
            effects = _once_each((*h.effects[:i], *some, *h.effects[i + 1 :]))
            if not effects or not possible.issuperset(some):
                continue
            places = {(s, place): c.places[0] if c.law.acts == "pair" else place for s in some for place in s.places}
            like = {s.row(p, place): values.get(_like(c, p, at)) for (s, place), at in places.items() for p in s.law.parameters}
            free = (*retuned, *effect_parameters(effects, weighed.model.scales))
            x = np.array([values.get(f.row, like.get(f.row) or f.center or LITTLE * f.sd) for f in free])
            wanted.append(Start(effects, free, x, np.inf))
    return refined(weighed, judged, wanted)


def in_its_place(weighed: Weighed, judged: np.ndarray, h: Hypothesis) -> list[Hypothesis]:
    """The special cases and mimics of a hypothesis, and those of the best of these, while that leaves less."""
    found = special_cases(weighed, judged, h)
    best = min(found, key=lambda s: s.left, default=h)
    return [*found, *in_its_place(weighed, judged, best)] if best.left < h.left else found


def _in_place_of(c: Candidate, *, alone: bool) -> list[tuple[Candidate, ...]]:
    """What may stand in the place of an effect, `alone` or one of several."""
    law = library()[c.effect]
    own = not alone or c.law.acts == "pair"
    names = (*(c.effect,) * own, *law.contains, *law.mimics, *(name for name in law.same_as if name in library()))
    others = [(s,) for name in names for form in library()[name].forms for s in _within(c, name, form) if s != c]
    return [*others, *_at_the_other(c)]


def _once_each(effects: Sequence[Candidate]) -> tuple[Candidate, ...]:
    """Effects of which a form that stands at either joint is one at both; none where that leaves a name twice."""
    once: dict[str, Candidate] = {}
    for c in effects:
        other = once.setdefault(c.effect, c)
        if other is not c:
            if other.form != c.form or set(other.joints) & set(c.joints):
                return ()
            once[c.effect] = replace(other, joints=tuple(sorted((*other.joints, *c.joints))))
    return tuple(once.values())


def _like(c: Candidate, p: Parameter, place: int) -> str:
    """Row of an effect's parameter that says what one of another law says: of the same name, or of sizes the only one of its unit."""
    alike = [own for own in c.law.parameters if own.name == p.name] or [
        own for own in c.law.sizes if own.dimension == p.dimension and not p.shape
    ]
    return c.row(alike[0], place) if len(alike) == 1 else ""


def _within(c: Candidate, name: str, form: Form) -> list[Candidate]:
    """A form of another name at the joints of an effect; of one that couples two joints, at each by itself as well."""
    if (form.acts == "pair") == (c.law.acts == "pair"):
        return [Candidate(name, form.name, c.joints)]
    return [Candidate(name, form.name, j) for j in (*((j,) for j in c.joints), c.joints)] if c.law.acts == "pair" else []


def _at_the_other(c: Candidate) -> list[tuple[Candidate, Candidate]]:
    """An effect of two joints at one of them, beside its special cases at the other: in the same form if they have it."""
    found = []
    for name in library()[c.effect].contains:
        forms = library()[name].forms
        form = next((f for f in forms if f.name == c.form), forms[0])
        if form.acts == c.law.acts:
            found += [(replace(c, joints=(own,)), Candidate(name, form.name, (other,))) for own, other in permutations(c.places, 2)]
    return found


def _less(h: Hypothesis, effects: tuple[Candidate, ...]) -> Start:
    """Where a hypothesis is, with no more than these effects."""
    rows = {row for c in effects for shape in (False, True) for row, _ in c.rows(shape=shape)}
    kept = [i for i, f in enumerate(h.fit.free) if f.row.startswith("change.") or f.row in rows]
    return Start(effects, tuple(h.fit.free[i] for i in kept), h.fit.x[kept], np.inf)
