"""Every candidate in the linear picture about a fit: what it would take off the gap once all else, and the starts, have adapted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from hamr_description.numbers import value
from hamr_dynamics.effects.law import Form, Parameter
from hamr_dynamics.effects.library import find

from ..fitting.parameters import Free
from ..naming.hypothesis import SEEN
from .candidates import PLACES, UNITS, Shapes, kind, shapes_of, units
from .eliminate import Eliminated, bounded
from .fit import Fit, columns, weights
from .replay import Replay
from .setting import Candidate, Setting, setting

LARGE = 3.0  # typical sizes, at which responses are taken: contacts bend them, and chords order names and places as tangents do not
BATCH = 24  # models simulated at once
PASSED = 1.1  # of the largest drive, over a limit at which a response is taken
NEUTRAL = value("actuator.neutral_voltage")
WIDE = 30.0  # of typical sizes: the prior of a size


@dataclass(frozen=True, slots=True)
class Column:
    """A response: of a size of a form with some shapes at one unit of its places."""

    effect: str
    form: str
    shapes: Shapes
    unit: str
    size: str


@dataclass(frozen=True, eq=False)
class Solution:
    """A linear answer: candidates, their sizes and shapes by row in scales, and the half squares they take off."""

    effects: tuple[Candidate, ...]
    values: dict[str, float]
    gain: float

    @property
    def names(self) -> frozenset:
        """Families and places."""
        return frozenset(c.name for c in self.effects)


class Screen:
    """The picture about a fit.

    Attributes:
        about: the fit. slopes: (s, readings + 28, 28) derivatives by its starts. fixed: (s, readings + 28, P) by its free numbers.
    """

    def __init__(self, replay: Replay, about: Fit, wanted: Sequence[tuple[str, Form]]) -> None:
        self.about = about
        self.slopes = replay.slopes(about.change, about.residual, about.model)
        self.fixed = columns(replay, about.free, about.x, about.effects, about.change, about.residual)
        self._place: dict[Column, int] = {}
        self._reach = float(np.abs(replay.observed.drives.volts - NEUTRAL).max())
        responses, jobs = [], _jobs(wanted, self._reach)
        for at in range(0, len(jobs), BATCH):
            part = jobs[at : at + BATCH]
            left = replay.each(about.change, [_with(about, candidate, values) for _, candidate, values in part])
            for (column, _, values), r in zip(part, left, strict=True):
                if np.isfinite(r).all():
                    self._place[column] = len(responses)
                    responses.append(((about.residual - r) / values[column.size]).astype(np.float32))
        n, free = len(about.free), about.free
        all_columns = np.concatenate([self.fixed, np.stack(responses, -1)], -1)
        hessian, gradient = Eliminated(self.slopes).normal(all_columns, about.residual, weights(about.residual))
        sd, center = np.array([f.sd for f in free]), np.array([f.center for f in free])
        inner = hessian[:n, :n] + np.diag(sd**-2.0)
        follow = np.linalg.solve(inner, np.column_stack([hessian[:n, n:], gradient[:n] - (about.x - center) / sd**2]))
        self._hessian = hessian[n:, n:] - hessian[n:, :n] @ follow[:, :-1]
        self._gradient = gradient[n:] - hessian[n:, :n] @ follow[:, -1]
        self._own = np.diag(hessian)[n:].copy()

    def solve(self, effects: Sequence[Candidate], shapes: Sequence[Shapes]) -> Solution:
        """Best sizes of some candidates with shapes, with all else following."""
        sizes: list[tuple[Candidate, Parameter]] = [(c, p) for c in effects for p in c.law.sizes]
        mix = np.zeros((len(sizes), len(self._gradient)))
        for c, own in zip(effects, shapes, strict=True):
            for k, (other, p) in enumerate(sizes):
                if other is c:
                    mix[k, [i for u in units(c) if (i := self._place.get(Column(c.effect, c.form, own, u, p.name))) is not None]] = 1.0
        some = np.flatnonzero(mix.any(0))
        mix = mix[:, some]
        hessian, gradient = mix @ self._hessian[np.ix_(some, some)] @ mix.T, mix @ self._gradient[some]
        prior = np.array([(WIDE * p.typical) ** -2.0 for _, p in sizes])
        values = {c.row(p): dict(own)[p.name] for c, own in zip(effects, shapes, strict=True) for p in c.law.shapes}
        if (np.diag(hessian) <= prior).any():
            return Solution(tuple(effects), values, 0.0)
        low, high = np.array([p.low for _, p in sizes]), np.array([p.high for _, p in sizes])
        hessian = hessian + np.diag(prior)
        step = bounded(hessian, gradient, np.zeros(len(sizes)), low, high)
        values |= {c.row(p): self._begun(c, p, float(v)) for (c, p), v in zip(sizes, np.clip(step, low, high), strict=True)}
        return Solution(tuple(effects), values, float(gradient @ step - 0.5 * step @ hessian @ step))

    def _begun(self, c: Candidate, p: Parameter, size: float) -> float:
        """A size where a fit may begin: one with a threshold as far beyond that as its share of the response that was seen, or off."""
        if not p.screen:
            return size
        seen, met = _seen(c, p, self._reach), _met(c, p, self._reach)
        return met + (seen - met) * size / seen if size > SEEN * seen else 0.0

    def singles(self) -> list[Solution]:
        """Of each candidate with the shapes that suit it, largest gain first."""
        found: dict[Candidate, Solution] = {}
        for c, own in self._candidates():
            s = self.solve([c], [own])
            if c not in found or s.gain > found[c].gain:
                found[c] = s
        return sorted(found.values(), key=lambda s: -s.gain)

    def _candidates(self) -> list[tuple[Candidate, Shapes]]:
        """Each candidate with each set of shapes that was simulated."""
        seen = sorted({(c.effect, c.form, c.shapes) for c in self._place})
        return [(Candidate(name, form, place), own) for name, form, own in seen for place in PLACES[kind(find(name, form))]]


def _met(c: Candidate, p: Parameter, reach: float) -> float:
    """One over a limit, in scales, that the largest drive just meets."""
    return 1.0 / (c.scale(p) * reach)


def _seen(c: Candidate, p: Parameter, reach: float) -> float:
    """Size, in scales, at which a response is taken."""
    return PASSED * _met(c, p, reach) if p.screen else LARGE * p.typical


def _jobs(wanted: Sequence[tuple[str, Form]], reach: float) -> list[tuple[Column, Candidate, dict[str, float]]]:
    """Each column with its candidate and the parameters, in scales, at which it is simulated; the largest drive is `reach` V."""
    found = []
    for effect, form in wanted:
        for own, unit, p in product(shapes_of(form), UNITS[kind(form)], form.sizes):
            c = Candidate(effect, form.name, unit)
            found.append((Column(effect, form.name, own, unit, p.name), c, {p.name: _seen(c, p, reach)} | dict(own)))
    return found


def _with(about: Fit, candidate: Candidate, values: dict[str, float]) -> Setting:
    """A fit's model with one more effect, parameters in scales by name."""
    more = [Free(candidate.row(p), candidate.scale(p), 0.0, 0.0, 0.0, 1.0) for p in candidate.law.parameters]
    x = [values.get(p.name, p.typical if p.shape else 0.0) for p in candidate.law.parameters]
    return setting([*about.free, *more], np.concatenate([about.x, x]), [*about.effects, candidate])
