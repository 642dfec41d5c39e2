"""What the sensors make of a run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.signal import lfilter

from hamr_bags.as_measured import strokes
from hamr_description.names import Topic

from .case import Case, Truth

FRAME = 16  # samples in a 4 ms frame, lost together


def floors(case: Case) -> tuple[float, float]:
    """Standard deviation of the noise of angles (rad) and tips (m)."""
    full = strokes()
    return case.noise * full[Topic.SERVO_JOINTS], case.noise * full[Topic.SERVO_ACTUATORS]


def measured(case: Case, truth: Truth) -> Truth:
    """The run with the case's sensor noise; channels that are not recorded are NaN, lost samples are left out."""
    random = np.random.default_rng([case.seed, 1])
    columns = KINDS[case.noise_kind](random, len(truth.time))
    angles, tips = (y + floor * x for y, x, floor in zip((truth.angles, truth.tips), np.hsplit(columns, 2), floors(case), strict=True))
    if case.noise_kind == "repeats":
        stale = _stale(random, len(truth.time))
        angles, tips = angles[stale], tips[stale]
    if "deflections" not in case.channels:
        tips = np.full_like(tips, np.nan)
    run = replace(truth, angles=angles, tips=tips)
    if case.noise_kind != "dropouts":
        return run
    kept = ~np.repeat(random.random(-(-len(truth.time) // FRAME)) < 0.01, FRAME)[: len(truth.time)]
    return Truth(run.time[kept], run.volts[kept], run.angles[kept], run.tips[kept])


def _white(random: np.random.Generator, n: int) -> np.ndarray:
    return random.standard_normal((n, 4))


def _coloured(random: np.random.Generator, n: int) -> np.ndarray:
    """Correlated over 1 to 20 samples, the same standard deviation."""
    keep = np.exp(-1.0 / np.exp(random.uniform(0.0, 3.0)))
    return lfilter([np.sqrt(1 - keep**2)], [1, -keep], random.standard_normal((n, 4)), axis=0)


def _heavy(random: np.random.Generator, n: int) -> np.ndarray:
    """Student's t with three degrees of freedom, the same standard deviation."""
    return random.standard_t(3, (n, 4)) / np.sqrt(3.0)


def _stale(random: np.random.Generator, n: int) -> np.ndarray:
    """Indices of the samples really shown: one in fifty repeats the one before, sometimes for long."""
    index = np.arange(n)
    lost = random.random(n) < 0.02
    lost[0] = False
    return np.maximum.accumulate(np.where(lost, 0, index))


#: Noise of unit standard deviation, (n, 4): two angles, two tips.
KINDS = {"white": _white, "coloured": _coloured, "heavy": _heavy, "dropouts": _white, "repeats": _white}
