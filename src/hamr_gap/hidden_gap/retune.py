"""How well the leg without an effect explains a run once its parameters are tuned again, in floors of the sensor noise.

Tuned: drive gain, stiffness, damping, inertia and preload of each joint, gain and bias of each channel, one common time shift;
by Gauss-Newton steps with the machine itself, along finite differences taken from rough runs (one step a sample).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from hamr_description.units import length_to_si, time_from_si

from .case import JOINTS, Truth
from .machine import TIME_SHIFT, change, neutral
from .simulate import SAMPLE_HZ, rough

PER_MS = SAMPLE_HZ / time_from_si(1.0)
#: Kinds whose differences need a run, with the step taken; and how far each kind may wander where the data do not hold it.
STEPS = {"drive_gain": 1e-3, "stiffness": 1e-3, "damping": 2e-3, "inertia": 1e-3, "preload": 1e-4}
LEEWAY = {"damping": 0.6, "inertia": 0.15, "preload": 0.1, "bias": 0.1, "tip_bias": 0.05, TIME_SHIFT: 0.3}
FACTOR_LEEWAY = 0.3
#: Longest step, in leeways; and how much worse than foreseen a fit may be to count as found.
LONGEST, AS_FORESEEN = 1.0, 1.08


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
        """(2 n or 4 n,) angles rad and tips m in floors."""
        return np.hstack([angles / self.angle, tips / self.tip] if self.tips else [angles / self.angle]).ravel()

    def run(self, run: Truth) -> np.ndarray:
        """(2 n or 4 n,) channels of a run in floors."""
        return self(run.angles, run.tips)


@dataclass(frozen=True, slots=True)
class Directions:
    """What small changes of parameters do to a run.

    Attributes:
        names: keys of the changes, "kind.joint".
        around: (m,) values that the leeway is about.
        columns: (rows, m) floors per unit of change.
        leeway: (m,) standard deviation of what the data do not hold.
        normal: (m, m) normal matrix, the leeway's pull in it.
    """

    names: tuple[str, ...]
    around: np.ndarray
    columns: np.ndarray
    leeway: np.ndarray
    normal: np.ndarray

    def step(self, residual: np.ndarray, at: np.ndarray) -> tuple[float, np.ndarray, bool]:
        """Rms of what is left of a residual (rows,) after the best step from values `at` (m,); those after it; if it had to be cut."""
        pull = np.diag(self.leeway**-2.0)
        slope = self.columns.T @ residual - pull @ (at - self.around)
        move = np.linalg.solve(self.normal, slope)
        cut = np.abs(move / self.leeway).max() > LONGEST
        held = float(np.trace(self.normal * self.leeway**2)) * 1e-9
        while np.abs(move / self.leeway).max() > LONGEST:
            held *= 3.0
            move = np.linalg.solve(self.normal + held * pull, slope)
        return float(np.sqrt(np.mean((residual - self.columns @ move) ** 2))), at + move, bool(cut)


def directions(run: Truth, changes: Mapping[str, float], signal: Mapping, scale: Scale) -> Directions:
    """Of the parameters named above, about `run`, the leg with `changes` under an excitation."""

    def channels(given: Mapping[str, float]) -> np.ndarray:
        angles, tips = rough(given, signal)
        return scale(angles * change(given, "sensor_gain"), length_to_si(tips * change(given, "tip_gain")))

    rows, here = {}, channels(changes)
    for kind, step in STEPS.items():
        for joint in JOINTS:
            name = f"{kind}.{joint}"
            rows[name] = (channels({**changes, name: changes.get(name, neutral(kind)) + step}) - here) / step
    one, none = np.ones_like(run.angles), np.zeros_like(run.angles)
    for kind, angle, tip in (
        ("sensor_gain", run.angles, none), ("bias", one, none), ("tip_gain", none, run.tips), ("tip_bias", none, length_to_si(one)),
    ):  # fmt: skip
        for i, joint in enumerate(JOINTS):
            only = np.arange(len(JOINTS)) == i
            rows[f"{kind}.{joint}"] = scale(np.where(only, angle, 0.0), np.where(only, tip, 0.0))
    rows[TIME_SHIFT] = -PER_MS * scale(np.gradient(run.angles, axis=0), np.gradient(run.tips, axis=0))
    names, kinds = tuple(rows), [name.split(".")[0] for name in rows]
    columns = np.stack(list(rows.values()), axis=1)
    start = np.array([changes.get(name, neutral(kind)) for name, kind in zip(names, kinds, strict=True)])
    leeway = np.array([LEEWAY.get(kind, FACTOR_LEEWAY) for kind in kinds])
    return Directions(names, start, columns, leeway, columns.T @ columns + np.diag(leeway**-2.0))


class Retune:
    """Tunes the plain leg, or one with other effects, to a run; made for one case's changes and excitation."""

    def __init__(self, changes: Mapping[str, float], signal: Mapping, scale: Scale, plain: Truth) -> None:
        self._signal, self._scale = signal, scale
        self._start = directions(plain, changes, signal, scale)

    @property
    def start(self) -> dict[str, float]:
        """The changes it begins with, all kinds named."""
        return self._named(self._start.around)

    def gap(self, truth: Truth, model: Callable[[Mapping[str, float]], Truth], *, steps: int) -> float:
        """Rms in floors of truth minus the best model(changes) that at most `steps` Gauss-Newton steps find.

        Where a whole step went as foreseen, what is foreseen of the next one counts; else the best there was, or after a first step alone
        what it foresees.
        """
        goal, around, best, foreseen = self._scale.run(truth), self._start, np.inf, np.inf
        at = around.around
        for k in range(steps + 1):
            run = model(self._named(at))
            if k:
                around = replace(directions(run, self._named(at), self._signal, self._scale), around=self._start.around)
            rest = goal - self._scale.run(run)
            best = min(best, float(np.sqrt(np.mean(rest**2))))
            foreseen, at, cut = around.step(rest, at)
            if best < AS_FORESEEN * foreseen and not cut:
                return foreseen
        return foreseen if steps <= 1 else best

    def _named(self, values: np.ndarray) -> dict[str, float]:
        return dict(zip(self._start.names, values.tolist(), strict=True))
