"""Scaling a law until its effect has the strength asked for."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, partial

from hamr_description.errors import ModelError

from .case import Case, Effect, Truth
from .laws import LAWS
from .noise import floors
from .retune import Retune, Scale
from .simulate import play

#: Steps of the search and of what has no stiff law, ms; how near the strength is good enough in the search and at the end.
COARSE, FINE, NEAR, CLOSE = 0.05, 0.025, 0.03, 0.05
TRIALS, FINAL_TRIALS, FINAL_STEPS = 10, 4, 2
NOTHING = -3.0  # log of a share of the strength below which a law does not act at all: secants tell nothing


def scale_of(case: Case) -> Scale:
    """Floors of a case's channels."""
    return Scale(*floors(case), "deflections" in case.channels)


class Sizer:
    """Measures effects in one case's conditions; `case` is without effects."""

    def __init__(self, case: Case) -> None:
        self._case, self._scale = case, scale_of(case)
        self._plain = cache(partial(play, (), case.changes, case.excitation))
        self._retune = Retune(case.changes, case.excitation, self._scale, self._plain(step=COARSE))

    def strength(
        self, effects: tuple[Effect, ...], *, of: tuple[Effect, ...] | None = None, step: float = FINE, steps: int = FINAL_STEPS
    ) -> float:
        """Rms, in floors, of the run with `effects` minus the best re-tuned run without `of` (default all of them).

        `step` is the run's, ms; `steps` Gauss-Newton steps at most.
        """
        others = tuple(effect for effect in effects if of is not None and effect not in of)
        truth = play(effects, self._case.changes, self._case.excitation, step=step)

        def model(changes: Mapping[str, float]) -> Truth:
            if not others and changes == self._retune.start:
                return self._plain(step=max(step, FINE))
            return play(others, changes, self._case.excitation, step=max(step, FINE) if not others else step)

        return self._retune.gap(truth, model, steps=steps)

    def sized(self, effect: Effect) -> tuple[Effect, float] | None:
        """The effect scaled to the case's strength, and what it reached; None if its bounds, or a diverging run, forbid that."""
        law = LAWS[effect.law]
        low, high = map(math.log, law.ranges[law.size])
        start = math.log(effect.parameters[law.size])
        try:
            rough = self._search(partial(self._miss, effect, law.step if law.machine else COARSE, 1), low, high, start, NEAR, TRIALS)
            final = rough and self._search(partial(self._miss, effect, law.step, FINAL_STEPS), low, high, rough[0], CLOSE, FINAL_TRIALS)
        except ModelError:
            return None
        return (_of_size(effect, final[0]), math.exp(final[1]) * self._case.strength) if final else None

    def _miss(self, effect: Effect, step: float, steps: int, size: float) -> float:
        """log(strength / asked) at log size."""
        return math.log(max(self.strength((_of_size(effect, size),), step=step, steps=steps), 1e-6) / self._case.strength)

    @staticmethod
    def _search(miss: Callable, low: float, high: float, x: float, near: float, trials: int) -> tuple[float, float] | None:
        """Root of a rising function of log size by secants kept inside what is known; None if it is out of bounds."""
        below, above = (low, -math.inf), (high, math.inf)
        last = None
        for _ in range(trials):
            y = miss(x)
            if abs(math.expm1(y)) < near:
                return x, y
            if (y < 0.0 and x >= high) or (y > 0.0 and x <= low):
                return None
            slope = 1.0 if last is None or x == last[0] else (y - last[1]) / (x - last[0])
            slope = min(max(slope, 0.4), 6.0)
            below, above, last = (max(below, (x, y)), above, (x, y)) if y < 0.0 else (below, min(above, (x, y)), (x, y))
            x = min(max(x - max(min(y, 3.5), -3.5) / slope, low), high)
            if math.isfinite(below[1]) and math.isfinite(above[1]) and (below[1] < NOTHING or not below[0] < x < above[0]):
                x = 0.5 * (below[0] + above[0])
        return None


def _of_size(effect: Effect, size: float) -> Effect:
    return replace(effect, parameters=effect.parameters | {LAWS[effect.law].size: math.exp(size)})
