"""Sensors with coarse steps: found in how the residual hangs on the angle, for no derivative leads to them.

A sensor that knows multiples of a step adds a sawtooth of the angle to what it reads, whose first harmonic has the step over pi as
its size. The residual, summed over narrow classes of the simulated angle and transformed, shows it as a line of just that height. A
counter that moves on late has another sawtooth on the way up than on the way down, so each way is looked at by itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from scipy.optimize import minimize

from .fit import Fit
from .hypothesis import Hypothesis, judge, residual
from .parameters import Candidate, Free, effect_parameters
from .record import rounding
from .sensors import Sensors, late
from .weighed import Weighed

CLASSES = 1 << 14  # of the angle
FINER = 8  # points of the spectrum between two lines that the travel tells apart
FEWEST = 4.0  # steps in the whole travel
LINE = 40.0  # of the summed square, that a line has over the mean: chance gives 16 in one of a thousand records
HEIGHT = (0.6, 1.3)  # of the first harmonic, over step / pi
STEPPED = 0.8  # of what is left of a sensor, that must be left at most with its steps


@dataclass(frozen=True, slots=True)
class Staircase:
    """Of one joint's sensor: step and offset of its readings, Q; share of a step by which it is late; spread of the step found."""

    step: float
    offset: float
    stick: float
    spread: float


def staircases(weighed: Weighed, judged: np.ndarray, h: Hypothesis) -> dict[int, Staircase]:
    """Joint -> its sensor's steps, where they show beside a hypothesis and it leaves less of that sensor with them."""
    if not (seen := _seen(weighed, h.fit)):
        return {}
    each = (residual(weighed, x.fit) for x in (h, with_stairs(weighed, judged, h, seen)))
    before, after = (np.nanmean(np.where(judged, left**2, np.nan), axis=0) for left in each)
    gone = after < STEPPED * before
    return {own: steps for own, steps in seen.items() if gone[weighed.model.own.index(own)]}


def _seen(weighed: Weighed, found: Fit) -> dict[int, Staircase]:
    """Joint -> steps that show beside a fit; sensors whose readings are multiples of a step have no secret."""
    model, record = weighed.model, weighed.model.record
    each = replace(model, mean=1)
    run = late(each.runs(found.free, found.x)[0], found.sensors.shift, record.step, each.starts)
    left = record.readings - ((1.0 + found.sensors.gain) * run + found.sensors.bias)
    seen = {}
    for c, own in enumerate(model.own):
        if own < len(model.machine.joints) and rounding(record.readings[:, c]) == 0.0:
            known = np.isfinite(left[:, c])
            if stairs := staircase(run[known, c], left[known, c]):
                seen[own] = stairs
    return seen


def staircase(angle: np.ndarray, left: np.ndarray) -> Staircase | None:
    """The steps that a residual (n,) shows over the angle (n,), if any."""
    low, travel = angle.min(), np.ptp(angle)
    if travel == 0.0:
        return None
    count, square = len(left), np.sum((left - left.mean()) ** 2)
    rising = np.gradient(angle) > 0.0
    ways = [(angle[way], left[way] - left[way].mean()) for way in (rising, ~rising) if way.any()]
    summed = (np.bincount(np.minimum(((q - low) / travel * CLASSES).astype(int), CLASSES - 1), x, CLASSES) for q, x in ways)
    spectrum = sum(np.abs(np.fft.rfft(x, FINER * CLASSES)[: FINER * CLASSES // 8]) for x in summed)
    power = spectrum**2 / square
    steps_in_travel = np.arange(len(power)) / FINER
    first = int(FEWEST * FINER)
    height = 2.0 * np.pi * spectrum[first:] / count * steps_in_travel[first:] / travel  # over step / pi
    fits = (power[first:] > LINE) & (HEIGHT[0] < height) & (height < HEIGHT[1])
    if not fits.any():
        return None
    k = first + int(np.argmax(np.where(fits, power[first:], 0.0)))
    about = travel / steps_in_travel[k]
    near = about * (1.0 + np.linspace(-0.25, 0.25, 81) / steps_in_travel[k])
    best = max(near.tolist(), key=lambda step: sum(abs(_line(q, x, step)) for q, x in ways))
    # read - angle is a sum over m of step / (pi m) (-1)^m sin(2 pi m (angle - offset) / step): about -sin for m = 1, a phase of +90 degrees
    up, *down = (-(np.angle(_line(q, x, best)) - 0.5 * np.pi) / (2.0 * np.pi) for q, x in ways)
    down = down[0] if down else up
    late, prompt = 0.5 * ((up - down) % 1.0), np.angle(np.exp(2j * np.pi * up) + np.exp(2j * np.pi * down)) / (2.0 * np.pi)
    ways = [np.array([best, (down + late) * best, late]), np.array([best, prompt * best, 0.0])]
    step, offset, stick = min(ways, key=lambda way: _missed(way, angle, left))
    if stick:  # near the turns of the motion its sawteeth are none, so what was seen is not exact
        simplex = np.array([step, offset, stick]) + np.vstack([np.zeros(3), np.diag([0.01 * step, 0.1 * step, 0.05])])
        closer = minimize(_missed, simplex[0], (angle, left), "Nelder-Mead", options={"initial_simplex": simplex, "maxfev": 150})
        step, offset, stick = closer.x
    return Staircase(
        float(step), float((offset + 0.5 * step) % step - 0.5 * step), float(abs(stick)), float(best**2 / travel / np.sqrt(power[k]))
    )


def _missed(x: Sequence[float], angle: np.ndarray, left: np.ndarray) -> float:
    """Variance that a step, offset and delay leave of a residual."""
    step, offset, stick = x
    return float(np.var(left - (step * np.floor((_played(angle, abs(stick) * step) - offset) / step + 0.5) + offset - angle)))


@njit(cache=True)
def _played(angle: np.ndarray, play: float) -> np.ndarray:
    out, now = np.empty_like(angle), angle[0]
    for k in range(angle.size):
        now = min(max(now, angle[k] - play), angle[k] + play)
        out[k] = now
    return out


def _line(angle: np.ndarray, left: np.ndarray, step: float) -> complex:
    return complex(np.sum(left * np.exp(-2j * np.pi * angle / step)))


def with_stairs(weighed: Weighed, judged: np.ndarray, h: Hypothesis, stairs: dict[int, Staircase]) -> Hypothesis:
    """A hypothesis with the steps of some sensors besides; nothing else is fitted anew, for steps move nothing on the average."""
    form = "hysteresis" if any(s.stick for s in stairs.values()) else "rounding"
    effect = Candidate("sensor_quantisation", form, tuple(sorted(stairs)))
    pinned = [_pinned(free, stairs[int(free.row.rsplit(".", 1)[1])]) for free in effect_parameters([effect], weighed.model.scales)]
    return judge(weighed, judged, (*h.effects, effect), _read(weighed, h.fit, pinned))


def _pinned(free: Free, stairs: Staircase) -> Free:
    """A parameter that stays where it was found."""
    name = free.row.split(".")[2]
    x, sd = {"step": (stairs.step, stairs.spread), "offset": (stairs.offset, 0.1 * stairs.step), "stick": (stairs.stick, 0.1)}[name]
    return replace(free, low=x / free.scale, high=x / free.scale, center=x / free.scale, sd=sd / free.scale)


def _read(weighed: Weighed, found: Fit, pinned: Sequence[Free]) -> Fit:
    """A fit with pinned parameters besides, its sensors solved for anew."""
    free, x = (*found.free, *pinned), np.append(found.x, [f.center for f in pinned])
    run = weighed.model.runs(free, x)[0]
    s, cost = weighed.solve_sensors(run[: weighed.until], found.sensors.shift)
    sensors: Sensors = weighed.sensors(s)
    reading = sensors.read(run, weighed.model.reading_step, weighed.model.starts)
    return Fit(free, x, sensors, run, reading, cost, found.converged)
