"""Steps of a coarse sensor, found in how a residual hangs on the angle, for no derivative leads to them.

A sensor that knows multiples of a step adds a sawtooth of the angle to what it reads, whose first harmonic has the step over pi as
its size. The residual, summed over narrow classes of the simulated angle and transformed, shows it as a line of just that height. A
counter that moves on late has another sawtooth on the way up than on the way down, so each way is looked at by itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.optimize import minimize

CLASSES = 1 << 14  # of the angle
FINER = 8  # points of the spectrum between two lines that the travel tells apart
FEWEST = 4.0  # steps in the whole travel
LINE = 40.0  # of the summed square, that a line has over the mean: chance gives 16 in one of a thousand records
HEIGHT = (0.6, 1.3)  # of the first harmonic, over step / pi


@dataclass(frozen=True, slots=True)
class Staircase:
    """Of one joint's sensor: step and offset of its readings, Q; share of a step by which it is late; spread of the step found."""

    step: float
    offset: float
    stick: float
    spread: float


def staircase(angle: np.ndarray, left: np.ndarray) -> Staircase | None:
    """The steps that a residual (n,) shows over the angle (n,), if any."""
    if np.ptp(angle) == 0.0:
        return None
    rising = np.gradient(angle) > 0.0
    ways = [(angle[way], left[way] - left[way].mean()) for way in (rising, ~rising) if way.any()]
    if (seen := _line_of(ways, angle, left)) is None:
        return None
    step, spread = seen
    # read - angle is a sum over m of step / (pi m) (-1)^m sin(2 pi m (angle - offset) / step): about -sin for m = 1, a phase of +90 degrees
    up, *down = (-(np.angle(_harmonic(q, x, step)) - 0.5 * np.pi) / (2.0 * np.pi) for q, x in ways)
    down = down[0] if down else up
    late, prompt = 0.5 * ((up - down) % 1.0), np.angle(np.exp(2j * np.pi * up) + np.exp(2j * np.pi * down)) / (2.0 * np.pi)
    either = [np.array([step, (down + late) * step, late]), np.array([step, prompt * step, 0.0])]
    step, offset, stick = min(either, key=lambda x: _missed(x, angle, left))
    if stick:  # near the turns of the motion its sawteeth are none, so what was seen is not exact
        simplex = np.array([step, offset, stick]) + np.vstack([np.zeros(3), np.diag([0.01 * step, 0.1 * step, 0.05])])
        closer = minimize(_missed, simplex[0], (angle, left), "Nelder-Mead", options={"initial_simplex": simplex, "maxfev": 150})
        step, offset, stick = closer.x
    return Staircase(float(step), float((offset + 0.5 * step) % step - 0.5 * step), float(abs(stick)), spread)


def _line_of(ways: Sequence[tuple[np.ndarray, np.ndarray]], angle: np.ndarray, left: np.ndarray) -> tuple[float, float] | None:
    """The step of the strongest line that has the height of a sawtooth of that step, and its spread.

    Args:
        ways: angles and residuals on the way up, and on the way down.
    """
    low, travel = angle.min(), np.ptp(angle)
    summed = (np.bincount(np.minimum(((q - low) / travel * CLASSES).astype(int), CLASSES - 1), x, CLASSES) for q, x in ways)
    spectrum = sum(np.abs(np.fft.rfft(x, FINER * CLASSES)[: FINER * CLASSES // 8]) for x in summed)
    power = spectrum**2 / np.sum((left - left.mean()) ** 2)
    steps_in_travel = np.arange(len(power)) / FINER
    first = int(FEWEST * FINER)
    height = 2.0 * np.pi * spectrum[first:] / len(left) * steps_in_travel[first:] / travel  # over step / pi
    fits = (power[first:] > LINE) & (HEIGHT[0] < height) & (height < HEIGHT[1])
    if not fits.any():
        return None
    k = first + int(np.argmax(np.where(fits, power[first:], 0.0)))
    near = travel / steps_in_travel[k] * (1.0 + np.linspace(-0.25, 0.25, 81) / steps_in_travel[k])
    best = max(near.tolist(), key=lambda step: sum(abs(_harmonic(q, x, step)) for q, x in ways))
    return best, float(best**2 / travel / np.sqrt(power[k]))


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


def _harmonic(angle: np.ndarray, left: np.ndarray, step: float) -> complex:
    return complex(np.sum(left * np.exp(-2j * np.pi * angle / step)))
