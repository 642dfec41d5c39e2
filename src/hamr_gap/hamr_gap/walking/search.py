"""Find and name on the ground: a re-tune, all candidates in the linear picture, the best fitted alone and in pairs and judged elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations

import numpy as np

from hamr_description.errors import BagError

from ..analyse import SMALLEST
from ..parameters import Free
from ..weigh import better
from .fit import Fit, fit
from .robot import NUMERICS, Robot
from .screen import Screen, Solution, forms
from .segments import CHANGES, Segments, segments
from .setting import Candidate, Setting, effect_parameters, retune
from .starts import Replay, Started, start
from .walk import Walk

LENGTH_MS = 40.0  # of a segment: what acts on the body shows as the square of time, and contact stays predictable
TURN_MS = 500.0  # in which segments serve one role
TURNS = ("fit", "select", "fit", "calibrate", "fit", "select", "fit", "report")
FITTED, JUDGED = 36, 48  # segments that are fitted, and that serve each other role, at most
BLOCK_MS = 100.0  # of judged segments, that count as one
CLOSE = 6.0  # mean square that a model as given may leave for the finest steps to matter
SETTLING = 4  # times that the best is fitted on, at most
WORST = 0.1  # of the judged segments, that do not count: their contact may have gone another way
SINGLES = 6  # names fitted
ALL_FORMS = 2  # of these, in all their forms
PAIRS = 3
POLISHED, RIVAL, AGAIN = 4, 3.0, 3  # how many are fitted again, that leave less than so many times what the best leaves; and how often
ENOUGH = 0.03  # of the gap, that another effect must promise


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """Some effects (none: a re-tune alone), fitted.

    Attributes:
        effects. fit. left: mean square of judged readings in units of noise, without the worst segments. blocks: (b,) the same of blocks.
    """

    effects: tuple[Candidate, ...]
    fit: Fit
    left: float
    blocks: np.ndarray

    @property
    def names(self) -> frozenset:
        """Families and places."""
        return frozenset(c.name for c in self.effects)

    @property
    def parameters(self) -> int:
        """Number of sizes and shapes."""
        return sum(len(c.law.parameters) for c in self.effects)


@dataclass
class Search:
    """What was tried.

    Attributes:
        parts: role -> replay. starts: role -> starts under the re-tuned model. raw, base: the model as given, and re-tuned.
        numerical: rms by which coarser steps move readings, in units of noise, halved: the error of the simulation.
        floor: mean square that noise leaves. tried: all hypotheses with effects.
    """

    parts: dict[str, Replay]
    starts: dict[str, Started]
    raw: Hypothesis
    base: Hypothesis
    numerical: float
    floor: float
    tried: list[Hypothesis] = field(default_factory=list)

    @property
    def least(self) -> float:
        """Mean square that counts as a gap: more than the simulation's own error, and a quarter of a sample's noise."""
        return max(self.parts["fit"].observed.mean * SMALLEST**2, (0.5 * self.numerical) ** 2)

    @property
    def best(self) -> Hypothesis:
        """The one that leaves least."""
        return min([self.base, *self.tried], key=lambda h: h.left)

    def by_names(self) -> dict[frozenset, Hypothesis]:
        """The best hypothesis for every set of names."""
        found: dict[frozenset, Hypothesis] = {}
        for h in self.tried:
            if h.names not in found or h.left < found[h.names].left:
                found[h.names] = h
        return found


def roles(whole: Segments) -> dict[str, np.ndarray]:
    """Role -> indices of segments, in turns of `TURN_MS`.

    Raises:
        BagError: too short for every role to have its turn.
    """
    turn = ((whole.first - whole.first[0]) * whole.walk.step // TURN_MS).astype(int)
    name = np.array(TURNS)[turn % len(TURNS)]
    found = {role: np.flatnonzero(name == role) for role in dict.fromkeys(TURNS)}
    if not all(map(len, found.values())):
        need = len(TURNS) * TURN_MS / 1e3
        lasts = whole.walk.step * len(whole.walk.angles) / 1e3
        raise BagError(f"The walk lasts {lasts:.1f} s: too short to fit on some and judge on others; record {need:g} s or more.")
    return {role: _thinned(index, FITTED if role == "fit" else JUDGED) for role, index in found.items()}


def _thinned(index: np.ndarray, most: int) -> np.ndarray:
    """No more than so many, evenly."""
    return index[np.unique(np.linspace(0, len(index) - 1, min(len(index), most)).astype(int))]


def search(backend: str, walk: Walk, report: Callable[[str], None] = lambda _: None) -> Search:
    """What could be missing from a backend on the ground.

    Raises:
        BagError: the walk cannot be used; one sentence.
    """
    state = _begin(backend, walk, report)
    report("screen")
    replay, base = state.parts["fit"], state.base.fit
    seen = Screen(replay, base, forms())
    singles = seen.singles()
    report("singles")
    state.tried += [_single(state, s) for s in _forms(singles)]
    if state.base.left - state.best.left > state.least:
        report("again")
        _polish(state)
        report("pairs")
        state.tried += _pairs(state, seen, singles)
        report("settle")
        _settle(state)
    state.floor = min(state.floor, state.best.left)
    return state


def _begin(backend: str, walk: Walk, report: Callable[[str], None]) -> Search:
    whole = segments(walk, length_ms=LENGTH_MS, every_ms=LENGTH_MS)
    part = roles(whole)
    report("starts")
    left, replay, begun = np.inf, None, None
    for finer in NUMERICS:
        if left > CLOSE and finer == NUMERICS[-1]:
            break  # what is missing is much larger than what steps of half the length move
        other = Replay.of(Robot(backend, finer), whole.some(part["fit"]))
        new = start(other, Setting())
        if (found := trimmed(new.residual[:, :-CHANGES])[0]) < left:
            left, replay, begun = found, other, new
    report("re-tune")
    free = retune(replay.robot.rest())
    tuned = fit(replay, free, np.zeros(len(free)), (), begun.change)
    parts = {"fit": replay} | {role: Replay.of(replay.robot, whole.some(part[role])) for role in ("select", "calibrate", "report")}
    starts = {role: start(parts[role], tuned.model) for role in ("select", "calibrate")}
    raw = start(parts["select"], Setting())
    nothing = Fit((), np.zeros(0), (), begun.change, begun.residual, 0.0, np.zeros((0, 0)))
    given, base = (Hypothesis((), f, *left_of(parts["select"], begun)) for f, begun in ((nothing, raw), (tuned, starts["select"])))
    return Search(parts, starts, given, base, _numerical(replay, tuned), 1.0 - CHANGES / replay.observed.readings)


def _numerical(replay: Replay, tuned: Fit) -> float:
    """Rms by which the next finer steps move readings; of the finest, half of what the next coarser ones do."""
    at = NUMERICS.index(replay.robot.numerics)
    last = at == len(NUMERICS) - 1
    other = Replay.of(Robot(replay.robot.backend, NUMERICS[at - 1 if last else at + 1]), replay.segments)
    away = other.each(tuned.change, [tuned.model])[0] - tuned.residual
    slopes = replay.slopes(tuned.change, tuned.residual, tuned.model)
    own = np.linalg.solve(slopes.transpose(0, 2, 1) @ slopes, slopes.transpose(0, 2, 1) @ away[..., None])
    rest = away - (slopes @ own)[..., 0]  # starts would follow
    return float(np.sqrt(trimmed(rest[:, :-CHANGES])[0])) * (0.5 if last else 1.0)


def trimmed(residual: np.ndarray) -> tuple[float, np.ndarray]:
    """Mean square of (s, c) without the worst segments, and (s,) of each segment."""
    each = np.mean(residual**2, 1)
    return float(np.mean(np.sort(each)[: max(1, round((1.0 - WORST) * len(each)))])), each


def left_of(replay: Replay, begun: Started) -> tuple[float, np.ndarray]:
    """Mean square that started segments leave, and (b,) of blocks."""
    left, each = trimmed(begun.residual[:, :-CHANGES])
    block = (replay.segments.first * replay.segments.walk.step // BLOCK_MS).astype(int)
    return left, np.array([each[block == b].mean() for b in np.unique(block)])


def judge(state: Search, role: str, model: Setting) -> tuple[float, np.ndarray]:
    """What a model leaves of a role's readings, its starts fitted on from those of the re-tuned one."""
    return left_of(state.parts[role], start(state.parts[role], model, state.starts[role].change))


def _single(state: Search, solution: Solution) -> Hypothesis:
    """Fits an effect for good, twice: beside the re-tune, and beside the model as given, since a re-tune swallows much of most effects."""
    replay, own = state.parts["fit"], effect_parameters(solution.effects)
    x = _inside(own, solution)
    alone = fit(replay, own, x, solution.effects, state.raw.fit.change)
    n = len(state.base.fit.free)
    both = [
        fit(replay, [*state.base.fit.free, *own], np.concatenate(begin), solution.effects, change)
        for begin, change in (((solution.base, x), state.base.fit.change), ((np.zeros(n), alone.x), alone.change))
    ]
    found = min(both, key=lambda f: trimmed(f.residual)[0])
    return Hypothesis(solution.effects, found, *judge(state, "select", found.model))


def _refine(state: Search, solution: Solution) -> Hypothesis:
    """Fits a set of effects for good, from its linear solution."""
    own = effect_parameters(solution.effects)
    x = np.concatenate([solution.base, _inside(own, solution)])
    found = fit(state.parts["fit"], [*state.base.fit.free, *own], x, solution.effects, state.base.fit.change)
    return Hypothesis(solution.effects, found, *judge(state, "select", found.model))


def _inside(free: Sequence[Free], solution: Solution) -> np.ndarray:
    """(P,) a solution's numbers, strictly inside their bounds."""
    edge = 1e-3 * np.array([f.sd for f in free])
    x = np.array([solution.values.get(f.row, f.center) for f in free])
    return np.clip(x, np.array([f.low for f in free]) + edge, np.array([f.high for f in free]) - edge)


def _polish(state: Search) -> None:
    """Fits the best again from starts of their own: those of the re-tuned model may have feet where only a wrong model puts them."""
    for h in sorted(state.tried, key=lambda h: h.left)[:POLISHED]:
        for _ in range(AGAIN):
            if h.left > RIVAL * state.best.left:
                break
            again = _again(state, h)
            if again.left > 0.98 * h.left:
                break
            state.tried[state.tried.index(h)] = h = again


def _settle(state: Search) -> None:
    """Fits the best on until it stays where it is; what it still moves in the end its intervals will count."""
    for _ in range(SETTLING):
        best = state.best
        again = _again(state, best)
        if again.left > best.left:
            still = replace(best.fit, moved=np.maximum(best.fit.moved, np.abs(again.fit.x - best.fit.x)))
            state.tried[state.tried.index(best)] = replace(best, fit=still)
            return
        state.tried[state.tried.index(best)] = again


def _again(state: Search, h: Hypothesis) -> Hypothesis:
    """A hypothesis fitted on from where it is, with starts of its own."""
    found = fit(state.parts["fit"], h.fit.free, h.fit.x, h.effects, start(state.parts["fit"], h.fit.model).change)
    found = replace(found, moved=np.abs(found.x - h.fit.x))
    return Hypothesis(h.effects, found, *left_of(state.parts["select"], start(state.parts["select"], found.model)))


def _forms(singles: Sequence[Solution]) -> list[Solution]:
    """The first names, the very first in every form."""
    first: dict[tuple, Solution] = {}
    for s in singles:
        first.setdefault(s.effects[0].name, s)
    names = list(first)[:SINGLES]
    others = [s for s in singles if s.effects[0].name in names[:ALL_FORMS] and s is not first[s.effects[0].name]]
    return [*(first[name] for name in names), *others]


def _pairs(state: Search, seen: Screen, singles: Sequence[Solution]) -> list[Hypothesis]:
    """The best single with each other candidate, in a linear picture about it; and the best pairs about the re-tune."""
    best = state.best
    gap = state.base.left - state.floor
    if not best.effects or best.left - state.floor < max(ENOUGH * gap, state.numerical**2):
        return []
    others = [(effect, form) for effect, form in forms() if effect != best.effects[0].effect]
    beside = Screen(state.parts["fit"], best.fit, others).singles()
    found = []
    for s in _one_of_each(beside, PAIRS):
        values = s.values | {f.row: float(v) for f, v in zip(best.fit.free, s.base, strict=True)}
        both = Solution((*best.effects, *s.effects), values, np.array([values[f.row] for f in state.base.fit.free]), s.gain)
        found.append(_refine(state, both))
    shapes = {s.effects[0]: tuple((p.name, s.values[s.effects[0].row(p)]) for p in s.effects[0].law.shapes) for s in singles if s.values}
    known = {(c.effect, c.form, c.shapes) for c in seen.columns}
    kept = [s.effects[0] for s in _one_of_each(singles, 12) if (s.effects[0].effect, s.effects[0].form, shapes.get(s.effects[0])) in known]
    pairs = [seen.solve(pair, [shapes[c] for c in pair]) for pair in combinations(kept, 2) if pair[0].effect != pair[1].effect]
    done = {h.names for h in found}
    more = [p for p in sorted(pairs, key=lambda p: -p.gain) if frozenset(c.name for c in p.effects) not in done][:PAIRS]
    return [*found, *(_refine(state, p) for p in more)]


def _one_of_each(solutions: Sequence[Solution], count: int) -> list[Solution]:
    """The best of each name."""
    first: dict[frozenset, Solution] = {}
    for s in solutions:
        first.setdefault(frozenset(c.name for c in s.effects), s)
    return list(first.values())[:count]


def evidence(state: Search) -> tuple[float, float]:
    """t over blocks by which the best leaves less than the re-tune: on the segments that selected it, and on fresh ones."""
    best = state.best
    if not best.effects:
        return 0.0, 0.0
    fresh = left_of(state.parts["calibrate"], state.starts["calibrate"])[1]
    return better(state.base.blocks, best.blocks), better(fresh, judge(state, "calibrate", best.fit.model)[1])
