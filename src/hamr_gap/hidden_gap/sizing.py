"""Scaling a law until its effect has the strength asked for: sought on a brief run of the same kind, settled on the whole one."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hamr_description.errors import ModelError

from .case import Case, Effect, Truth
from .laws.law import LAWS
from .noise import floors
from .retune import MOST, Fit, Retune, Scale
from .simulate import play

#: Seconds of the brief run; steps of a first search and of the tuned leg, ms.
BRIEF, COARSE, FINE = 2.4, 0.05, 0.025
#: How near the strength a search must come, as a logarithm: by what is foreseen of the brief run, by tuning to it, to the whole run.
ROUGH, NEAR, CLOSE = 0.1, 0.06, math.log(1.05)
#: How far off the end of a search on the brief run, or a trial on the whole one, may be.
FAR = math.log(3.0)
NOTHING = -3.0  # log of a share of the strength below which a law does not act at all: secants tell nothing


@dataclass(frozen=True, slots=True)
class Sized:
    """An effect with the strength that it reaches, and the leg tuned to it."""

    effect: Effect
    fit: Fit


class Run:
    """A case's excitation for some seconds, and the leg tuned to what effects make of it."""

    def __init__(self, case: Case, seconds: float) -> None:
        self._changes, self._signal = case.changes, case.excitation | {"seconds": seconds}
        self.retune = Retune(case.changes, self._signal, Scale(*floors(case), "deflections" in case.channels), step=FINE)

    def truth(self, effects: tuple[Effect, ...], *, step: float) -> Truth:
        """The run with effects, integrated in steps of `step` ms."""
        return play(effects, self._changes, self._signal, step=step)


class Sizer:
    """Measures effects in one case's conditions; `case` is without effects."""

    def __init__(self, case: Case) -> None:
        self._strength = case.strength
        self._whole, self._brief = Run(case, case.seconds), Run(case, min(case.seconds, BRIEF))

    def sized(self, effect: Effect) -> Sized | None:
        """The effect scaled to the case's strength; None if its bounds, or a diverging run, forbid that."""
        law = LAWS[effect.law]
        low, high = map(math.log, law.ranges[law.size])
        x, slope, at = math.log(effect.parameters[law.size]), 1.0, None
        stages = ((self._brief, law.step if law.machine else COARSE, 1, ROUGH, 10), (self._brief, law.step, MOST, NEAR, 5),
                  (self._whole, law.step, MOST, CLOSE, 4))  # fmt: skip
        for run, step, most, near, trials in stages:
            fits = [Fit(math.inf, at, None)]

            def miss(size: float, run=run, step=step, most=most, fits=fits) -> float:
                last = fits[-1] if most > 1 else fits[0]
                truth = run.truth((_of_size(effect, size),), step=step)
                fits.append(run.retune.fit(truth, start=last.at, directions=last.directions, most=most))
                return math.log(max(fits[-1].gap, 1e-6) / self._strength)

            try:
                x, y, slope = search(miss, x, slope, low, high, near, trials, FAR if run is self._whole else math.inf)
            except ModelError:
                return None
            if abs(y) > (CLOSE if run is self._whole else FAR):
                return None
            found, at = _of_size(effect, x), fits[-1].at
            x, slope = min(max(x - y / slope, low), high), min(max(slope, 0.7), 2.0)
        return Sized(found, fits[-1])

    def together(self, sized: Sequence[Sized]) -> tuple[float, ...]:
        """Strength, in floors, of all effects, and of each in the others' company."""
        effects, step, fit = tuple(one.effect for one in sized), min(LAWS[one.effect.law].step for one in sized), self._whole.retune.fit
        truth = self._whole.truth(effects, step=step)
        all_moves = np.sum([one.fit.at for one in sized], axis=0) - (len(sized) - 1) * self._whole.retune.start
        everything = fit(truth, start=all_moves, directions=sized[0].fit.directions)
        each = (fit(truth, others=tuple(other for other in effects if other is not one.effect), start=one.fit.at,
                    directions=one.fit.directions) for one in sized)  # fmt: skip
        return everything.gap, *(found.gap for found in each)


def search(
    miss: Callable[[float], float], x: float, slope: float, low: float, high: float, near: float, trials: int, far: float = math.inf
) -> tuple[float, float, float]:
    """Secants for the root of a rising function, kept inside what is known: the last x tried, what is missed there, the slope.

    Ends where it is near enough, at a bound, after the last trial, or further off than `far` and, if that is finite, the trial before.
    """
    below, above, last = (low, -math.inf), (high, math.inf), None
    for _ in range(trials):
        y = miss(x)
        if last is not None and x != last[0]:
            slope = min(max((y - last[1]) / (x - last[0]), 0.4), 6.0)
        if abs(y) < near or (y < 0.0 and x >= high) or (y > 0.0 and x <= low) or abs(y) > far:
            return x, y, slope
        if far < math.inf:
            far = abs(y)
        below, above, last = (max(below, (x, y)), above, (x, y)) if y < 0.0 else (below, min(above, (x, y)), (x, y))
        x = min(max(x - max(min(y, 3.5), -3.5) / slope, low), high)
        if math.isfinite(below[1]) and math.isfinite(above[1]) and (below[1] < NOTHING or not below[0] < x < above[0]):
            x = 0.5 * (below[0] + above[0])
    return *last, slope


def _of_size(effect: Effect, size: float) -> Effect:
    return replace(effect, parameters=effect.parameters | {LAWS[effect.law].size: math.exp(size)})
