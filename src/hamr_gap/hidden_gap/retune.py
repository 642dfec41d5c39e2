"""How well the leg without an effect explains a run once its parameters are tuned again, in floors of the sensor noise.

Tuned: drive gain, stiffness, damping, inertia and preload of each joint, gain and bias of each channel, one common time shift;
by Gauss-Newton steps with the machine itself, along finite differences taken from rough runs (one or two steps a sample).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from hamr_description.simple_constants import simple_constants
from hamr_description.units import length_to_si, time_from_si

from .case import JOINTS, Effect, Truth
from .laws.law import LAWS
from .machine import FACTORS, TIME_SHIFT, change, neutral
from .simulate import SAMPLE_HZ, play, rough

PER_MS = SAMPLE_HZ / time_from_si(1.0)
#: Kinds whose differences need a run, with the step taken; and how far each kind may wander where the data do not hold it.
STEPS = {"drive_gain": 1e-3, "stiffness": 1e-3, "damping": 2e-3, "inertia": 1e-3, "preload": 1e-4}
LEEWAY = {"damping": 0.6, "inertia": 0.15, "preload": 0.1, "bias": 0.1, "tip_bias": 0.05, TIME_SHIFT: 0.3}
FACTOR_LEEWAY = 0.3
NAMES = (*(f"{kind}.{joint}" for kind in (*STEPS, "sensor_gain", "bias", "tip_gain", "tip_bias") for joint in JOINTS), TIME_SHIFT)
KINDS = tuple(name.split(".")[0] for name in NAMES)
ALLOWED = np.array([LEEWAY.get(kind, FACTOR_LEEWAY) for kind in KINDS])
IS_FACTOR = np.array([kind in FACTORS for kind in KINDS])
#: Longest step, in leeways; how much more than foreseen may be left, if directions are old, and in the end; how much that may change.
LONGEST, STALE, AS_FORESEEN, SETTLED = 2.0, 1.06, 1.03, 0.02
#: End stops of the leg, rad, and how near them a run is still clear of them.
STOPS = np.array([simple_constants()["front"][name] for name in ("stop_low", "stop_high")])
CLEAR = 0.9
#: Every how many samples the gap is looked at; runs kept; Gauss-Newton steps.
THIN, KEPT, MOST = 3, 6, 6


@dataclass(frozen=True, slots=True)
class Scale:
    """What turns a run into floors.

    Attributes:
        angle, tip: floors, rad and m.
        tips: tips count as a channel.
    """

    angle: float
    tip: float
    tips: bool

    def __call__(self, angles: np.ndarray, tips: np.ndarray) -> np.ndarray:
        """(rows,) every THINth of angles (n, 2) rad and tips (n, 2) m, in floors."""
        angles, tips = angles[::THIN], tips[::THIN]
        return np.hstack([angles / self.angle, tips / self.tip] if self.tips else [angles / self.angle]).ravel()

    def run(self, run: Truth) -> np.ndarray:
        """(rows,) channels of a run in floors."""
        return self(run.angles, run.tips)


@dataclass(frozen=True, slots=True)
class Directions:
    """What small changes of parameters do to a run.

    Factors change by their logarithms: gains of drive and sensor, or of everything that moves a leg, trade off on straight lines then.

    Attributes:
        columns: (rows, m) floors per leeway of each parameter.
        around: (m,) coordinates, in leeways, that the leeway is about.
        normal: (m, m) normal matrix, the leeway's pull in it.
    """

    columns: np.ndarray
    around: np.ndarray
    normal: np.ndarray

    @classmethod
    def of(cls, columns: np.ndarray, around: np.ndarray) -> Directions:
        """With their normal matrix."""
        return cls(columns, around, columns.T @ columns + np.eye(columns.shape[1]))

    def step(self, residual: np.ndarray, at: np.ndarray) -> tuple[float, np.ndarray, bool]:
        """Rms of what is left of a residual (rows,) after the best step from coordinates `at`; those after it; if it had to be cut."""
        slope = self.columns.T @ residual - (at - self.around)
        move = np.linalg.solve(self.normal, slope)
        cut = np.abs(move).max() > LONGEST
        held = float(np.trace(self.normal)) * 1e-9
        while np.abs(move).max() > LONGEST:
            held *= 3.0
            move = np.linalg.solve(self.normal + held * np.eye(len(move)), slope)
        return _rms(residual - self.columns @ move), at + move, bool(cut)

    def seen(self, move: np.ndarray, change: np.ndarray) -> Directions:
        """Corrected, by Broyden's rule, for the change (rows,) of the run that a move brought."""
        return Directions.of(self.columns + np.outer(change - self.columns @ move, move / (move @ move)), self.around)


@dataclass(frozen=True, slots=True)
class Fit:
    """What is left, rms in floors, of a run after tuning; coordinates and directions that it was worked out with."""

    gap: float
    at: np.ndarray
    directions: Directions


class Retune:
    """Tunes the leg to runs under one excitation, beginning with a case's changes."""

    def __init__(self, changes: Mapping[str, float], signal: Mapping, scale: Scale, *, step: float) -> None:
        """`step` is that of the tuned leg, ms."""
        self._signal, self._scale, self._step = signal, scale, step
        self.start = _coordinates({name: changes.get(name, neutral(kind)) for name, kind in zip(NAMES, KINDS, strict=True)})
        self._plain = lru_cache(KEPT)(lambda at: self._run((), np.frombuffer(at)))
        self._directions = lru_cache(KEPT)(lambda at: self._directions_at(np.frombuffer(at)))

    def fit(
        self,
        truth: Truth,
        *,
        others: tuple[Effect, ...] = (),
        start: np.ndarray | None = None,
        directions: Directions | None = None,
        most: int = MOST,
    ) -> Fit:
        """Truth against the best tuned leg with the effects `others`.

        Gauss-Newton steps, at most `most`, from `start` along `directions`, or those worked out there. The gap is what is foreseen of the
        next step, once that is little more or has settled: valleys of parameters that trade off are long and bent, and a walk to
        their end takes far longer than it takes to know how deep they are.
        """
        at = self.start if start is None else start
        made_at = at if directions is None else None
        directions = directions or self._directions(at.tobytes())
        goal, best, best_at, best_rest, foreseen = self._scale.run(truth), np.inf, at, np.zeros(0), np.inf
        for _ in range(most):
            rest = goal - self._scale.run(self._run(others, at) if others else self._plain(at.tobytes()))
            if best < np.inf:
                directions = directions.seen(at - best_at, best_rest - rest)
            if (found := _rms(rest)) < best:
                best, best_at, best_rest = found, at, rest
            before = foreseen
            foreseen, at, cut = directions.step(best_rest, best_at)
            if (best < AS_FORESEEN * foreseen and not cut) or abs(before - foreseen) < SETTLED * foreseen:
                if best < STALE * foreseen or made_at is best_at or most == 1:
                    break
                directions, made_at = self._directions(best_at.tobytes()), best_at
                foreseen, at, cut = directions.step(best_rest, best_at)
        return Fit(foreseen, best_at, directions)

    def _run(self, others: tuple[Effect, ...], at: np.ndarray) -> Truth:
        step = min([self._step, *(LAWS[effect.law].step for effect in others)])
        return play(others, _changes(at), self._signal, step=step)

    def _directions_at(self, at: np.ndarray) -> Directions:
        """Directions of the leg without effects.

        One step a sample gives differences to a tenth, but where the run meets end stops, to nothing like the true ones.
        """
        run, changes = self._plain(at.tobytes()), _changes(at)
        parts = 1 if (np.abs(run.angles).max(axis=0) < CLEAR * np.abs(STOPS).min(axis=0)).all() else 2

        def channels(given: Mapping[str, float]) -> np.ndarray:
            angles, tips = rough(given, self._signal, parts)
            return self._scale(angles * change(given, "sensor_gain"), length_to_si(tips * change(given, "tip_gain")))

        here, one, none, columns = channels(changes), np.ones_like(run.angles), np.zeros_like(run.angles), []
        for kind, step in STEPS.items():
            for joint in JOINTS:
                name = f"{kind}.{joint}"
                columns.append((channels({**changes, name: changes[name] + step}) - here) / step)
        for angle, tip in ((run.angles, none), (one, none), (none, run.tips), (none, length_to_si(one))):
            for i in range(len(JOINTS)):
                only = np.arange(len(JOINTS)) == i
                columns.append(self._scale(np.where(only, angle, 0.0), np.where(only, tip, 0.0)))
        columns.append(-PER_MS * self._scale(np.gradient(run.angles, axis=0), np.gradient(run.tips, axis=0)))
        unit = np.where(IS_FACTOR, list(changes.values()), 1.0) * ALLOWED
        return Directions.of(np.stack(columns, axis=1) * unit, self.start)


def _coordinates(changes: Mapping[str, float]) -> np.ndarray:
    """(m,) changes in the order of NAMES, in leeways, factors as logarithms."""
    x = np.array([changes[name] for name in NAMES])
    x[IS_FACTOR] = np.log(x[IS_FACTOR])
    return x / ALLOWED


def _changes(at: np.ndarray) -> dict[str, float]:
    x = at * ALLOWED
    return dict(zip(NAMES, np.where(IS_FACTOR, np.exp(np.where(IS_FACTOR, x, 0.0)), x).tolist(), strict=True))


def _rms(x: np.ndarray) -> float:
    return float(np.sqrt(np.mean(x * x)))
