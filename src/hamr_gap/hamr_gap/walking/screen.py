"""Every candidate in the linear picture about the re-tuned robot: what it would take off the gap once re-tune and starts have adapted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from hamr_description.names import AXES, JOINTS, LEGS
from hamr_dynamics.effects.effects_file import OF_LEGS, OF_THE_CHASSIS
from hamr_dynamics.effects.law import Form
from hamr_dynamics.effects.library import find, library
from hamr_dynamics.effects.places import WORDS

from ..parameters import Free
from .fit import Eliminated, Fit, bounded, columns, weights
from .setting import Candidate, setting
from .starts import Replay

SMALL = 0.1  # of a typical size, at which responses are taken
BATCH = 24  # models simulated at once
OPTIONS = 3  # sets of shapes that are tried
PLACES = {"joint": ("all", *AXES, *LEGS, *JOINTS), "leg": ("all", *LEGS), "chassis": ("chassis",)}
#: Forms that remember for longer than a segment and what leads up to it.
SLOW = ("piezo_creep",)


def kind(form: Form) -> str:
    """Of which of PLACES a form is."""
    return "chassis" if form.acts in OF_THE_CHASSIS else "leg" if form.acts in OF_LEGS else "joint"


def missing(effect: str) -> str:
    """Why segments of a walk cannot show an effect; empty if they can."""
    needs = library()[effect].needs
    if effect in SLOW:
        return "it remembers for longer than a segment lasts"
    if "deflections" in needs:
        return "segments do not use sensors on the actuator's side; hang the robot up"
    if "quantised" in needs:
        return "it is seen in the readings themselves"
    return "it is no name" if "unnamed" in needs else ""


def forms() -> list[tuple[str, Form]]:
    """(effect, form) of all that may be named."""
    return [(name, form) for name, effect in library().items() if not missing(name) for form in effect.forms]


@dataclass(frozen=True)
class Column:
    """A response: of a size of a form at one unit of its places, with some shapes."""

    effect: str
    form: str
    shapes: tuple[tuple[str, float], ...]
    unit: str
    size: str


@dataclass(frozen=True)
class Solution:
    """A linear answer: candidate, shapes in scales, sizes by row in scales, base numbers (P,), and the half squares it takes off."""

    effects: tuple[Candidate, ...]
    values: dict[str, float]
    base: np.ndarray
    gain: float


class Screen:
    """The picture about a fit."""

    def __init__(self, replay: Replay, about: Fit, wanted: Sequence[tuple[str, Form]]) -> None:
        self.about = about
        self.free = about.free
        model = about.model
        slopes = replay.slopes(about.change, about.residual, model)
        linear = Eliminated(slopes, about.residual, weights(about.residual))
        fixed = columns(replay, about.free, about.x, about.effects, about.change, about.residual)
        self.columns, responses = [], []
        jobs = _jobs(wanted)
        for at in range(0, len(jobs), BATCH):
            part = jobs[at : at + BATCH]
            models = [_with(about, candidate, values) for _, candidate, values in part]
            left = replay.each(about.change, models)
            for (column, _, values), r in zip(part, left, strict=True):
                if np.isfinite(r).all():
                    self.columns.append(column)
                    responses.append(((about.residual - r) / values[column.size]).astype(np.float32))
        n = len(self.free)
        everything = np.concatenate([fixed, np.stack(responses, -1)], -1)
        hessian, gradient = linear.normal(everything)
        sd, center = np.array([f.sd for f in self.free]), np.array([f.center for f in self.free])
        hessian[:n, :n] += np.diag(sd**-2.0)
        gradient[:n] -= (about.x - center) / sd**2
        self.hessian, self.gradient = hessian, gradient

    def solve(self, effects: Sequence[Candidate], shapes: Sequence[tuple[tuple[str, float], ...]]) -> Solution:
        """Best sizes of some candidates with shapes, the re-tune along with them."""
        n, names, mix = len(self.free), [], []
        for c, own in zip(effects, shapes, strict=True):
            for p in c.law.sizes:
                wanted = {Column(c.effect, c.form, own, unit, p.name) for unit in _units(c)}
                mix.append([float(column in wanted) for column in self.columns])
                names.append((c, p))
        turn = np.zeros((n + len(mix), n + len(self.columns)))
        turn[:n, :n], turn[n:, n:] = np.eye(n), np.array(mix)
        hessian, gradient = turn @ self.hessian @ turn.T, turn @ self.gradient
        prior = np.array([(30.0 * p.typical) ** -2.0 for _, p in names])
        hessian[n:, n:] += np.diag(prior)
        if (np.diag(hessian)[n:] <= 2.0 * prior).any():
            return Solution(tuple(effects), {}, self.about.x, 0.0)
        x = np.concatenate([self.about.x, np.zeros(len(names))])
        low = np.concatenate([[f.low for f in self.free], [p.low for _, p in names]])
        high = np.concatenate([[f.high for f in self.free], [p.high for _, p in names]])
        step = bounded(hessian, gradient, x, low, high)
        gain = float(gradient @ step - 0.5 * step @ hessian @ step)
        values = {c.row(p): float(np.clip(v, lo, hi)) for (c, p), v, lo, hi in zip(names, step[n:], low[n:], high[n:], strict=True)}
        for c, own in zip(effects, shapes, strict=True):
            values |= {c.row(p): dict(own)[p.name] for p in c.law.shapes}
        return Solution(tuple(effects), values, self.about.x + step[:n], gain)

    def singles(self) -> list[Solution]:
        """Of each candidate with the shapes that suit it, largest gain first."""
        found: dict[Candidate, Solution] = {}
        for c, own in self.candidates():
            s = self.solve([c], [own])
            if c not in found or s.gain > found[c].gain:
                found[c] = s
        return sorted(found.values(), key=lambda s: -s.gain)

    def candidates(self) -> list[tuple[Candidate, tuple]]:
        """Each candidate with each set of shapes that was simulated."""
        seen = {(c.effect, c.form, c.shapes) for c in self.columns}
        return [(Candidate(name, form, place), own) for name, form, own in sorted(seen) for place in PLACES[kind(find(name, form))]]


def _units(c: Candidate) -> tuple[str, ...]:
    """The units that a place is made of."""
    if kind(c.law) == "joint":
        return c.joints
    return tuple(leg for leg in LEGS if f"{leg}_{AXES[0]}" in WORDS[c.place]) if kind(c.law) == "leg" else ("chassis",)


def _jobs(wanted: Sequence[tuple[str, Form]]) -> list[tuple[Column, Candidate, dict[str, float]]]:
    """Each column with its candidate and the parameters, in scales, at which it is simulated."""
    units = {"joint": JOINTS, "leg": LEGS, "chassis": ("chassis",)}
    found = []
    for effect, form in wanted:
        options = [[(p.name, v) for v in (p.screen or (p.typical,))] for p in form.shapes]
        for shapes in list(product(*options))[:OPTIONS]:
            for unit, p in product(units[kind(form)], form.sizes):
                size = p.screen[0] if p.screen else SMALL * p.typical
                column = Column(effect, form.name, tuple(shapes), unit, p.name)
                found.append((column, Candidate(effect, form.name, unit), {p.name: size} | dict(shapes)))
    return found


def _with(about: Fit, candidate: Candidate, values: dict[str, float]):
    """A fit's model with one more effect, parameters in scales by name."""
    more = [Free(candidate.row(p), candidate.scale(p), 0.0, 0.0, 0.0, 1.0) for p in candidate.law.parameters]
    x = [values.get(p.name, p.typical if p.shape else 0.0) for p in candidate.law.parameters]
    return setting([*about.free, *more], np.concatenate([about.x, x]), [*about.effects, candidate])
