"""All sizes of all effects free at once, each in its usual form, held by their priors alone; what differs from zero is named."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import lsq_linear

from ...fitting.fit import Fit
from ...fitting.linear import jacobian
from ...fitting.parameters import Candidate, Free, effect_parameters
from ...fitting.weighed import Weighed
from ...judging.interval import NORMAL_95, intervals
from ...naming.candidates import candidates
from ...naming.hypothesis import judge
from ...naming.prepare import Prepared
from .result import Path, Step, falling, together

SURE = 3.0  # standard deviations
SEEN = 1.0  # below which no threshold is of interest
JUMPS = 10.0  # times less must a hundredth of a size do
STEPS = 15  # of the fit
ENOUGH = 1e-3  # relative decrease of cost at which it ends
SHARES = np.array([1.0, 0.5, 0.25, 0.1, 0.03])  # of a step that are simulated
DAMPED = (0.0, 1e-3, 1e-1, 1.0)  # shares of its curvature added to each direction
BEGIN = 1e-3 / 30.0  # of the prior's standard deviation: a thousandth of what is typical, so that nothing starts on a bound


def everything(prepared: Prepared) -> Path:
    """One fit with every size at every place; the level of an effect is its most certain size in standard deviations."""
    weighed, base = prepared.weighed, prepared.base.fit
    machine = weighed.model.machine
    places = usual(single_places(candidates(machine, weighed.model.record)))
    sizes = {row: c for c in places for row, _ in c.rows(shape=False)}
    added = fading(prepared, [f for f in effect_parameters(places, weighed.model.scales) if f.row in sizes])
    free = (*base.free, *added)
    found = fit_all(weighed, free, np.concatenate([base.x, [BEGIN * f.sd for f in added]]))
    low, high = intervals(weighed, found).T
    sure = np.abs(found.x) / np.maximum((high - low) / (2 * NORMAL_95), 1e-300)
    level: dict[Candidate, float] = {}
    for f, t in zip(free, sure, strict=True):
        if f.row in sizes:
            level[sizes[f.row]] = max(level.get(sizes[f.row], 0.0), float(t))
    ranked = sorted((c for c in level if level[c] > SEEN), key=lambda c: -level[c])
    chosen = [together(ranked[: k + 1]) for k in range(len(ranked))]
    return Path(
        [Step(t, judge(weighed, prepared.judged, c, found)) for t, c in zip(falling(level[c] for c in ranked), chosen, strict=True)], SURE
    )


def fading(prepared: Prepared, sizes: Sequence[Free]) -> list[Free]:
    """Sizes whose effect vanishes with them: of one that jumps at zero (a stop's damper is there as soon as its spring is) there is no
    derivative to follow, and it stays off."""
    weighed, base = prepared.weighed, prepared.base.fit
    free, off = (*base.free, *sizes), np.concatenate([base.x, np.zeros(len(sizes))])
    small = np.diag(np.concatenate([np.zeros(len(base.x)), [BEGIN * f.sd for f in sizes]]))[len(base.x) :]
    plain = weighed.model.runs(free, off, weighed.until)[0]
    much, little = (
        np.array([np.abs(weighed.vector(y - plain)).max() for y in weighed.model.runs(free, off + share * small, weighed.until)])
        for share in (1.0, 0.01)
    )
    return [f for f, a, b in zip(sizes, much, little, strict=True) if a >= JUMPS * b]


def single_places(found: list[Candidate]) -> list[Candidate]:
    """Those at one joint each, and those of a pair."""
    return [c for c in found if len(c.joints) == 1 or c.law.acts == "pair"]


def usual(found: list[Candidate]) -> list[Candidate]:
    """Each effect in the first of its forms there is: with all of them at once, each would stand in for the others."""
    first: dict[tuple, str] = {}
    return [c for c in found if first.setdefault(c.name, c.form) == c.form]


def fit_all(weighed: Weighed, free: Sequence[Free], x: np.ndarray) -> Fit:
    """Least squares with priors over very many free numbers within bounds.

    As `fit`, but each step solves its linear picture under all bounds at once: so many sizes that may not be negative, and stand in for
    each other, leave an unbounded step no way down.
    """
    model, until = weighed.model, weighed.until
    low, high, center, sd = (np.array([getattr(f, name) for f in free]) for name in ("low", "high", "center", "sd"))
    run = model.runs(free, x, until)[0]
    s, cost = weighed.solve_sensors(run)
    cost += 0.5 * float(np.sum(((x - center) / sd) ** 2))
    precision, n = np.concatenate([sd**-2.0, weighed.sensor_precision]), len(free)
    for _ in range(STEPS):
        sensors = weighed.sensors(s)
        derivatives = jacobian(weighed, free, x, run, sensors)
        left = weighed.vector(model.target) - weighed.vector(sensors.read(run, model.reading_step, model.starts))
        gradient = derivatives.T @ left - precision * np.concatenate([x - center, s])
        hessian = derivatives.T @ derivatives + np.diag(precision)
        reach = np.concatenate([low - x, np.full(len(s), -np.inf)]), np.concatenate([high - x, np.full(len(s), np.inf)])
        steps = [_bounded(hessian + damping * np.diag(np.diag(hessian)), gradient, *reach)[:n] for damping in DAMPED]
        trials = np.clip(np.concatenate([x + SHARES[:, None] * step for step in steps]), low, high)
        best, decrease = None, 0.0
        for trial, y in zip(trials, model.runs(free, trials, until), strict=True):
            with np.errstate(over="ignore", invalid="ignore"):  # a run that diverges costs more than any
                solved, now = weighed.solve_sensors(y)
            now += 0.5 * float(np.sum(((trial - center) / sd) ** 2))
            if cost - now > decrease:
                best, decrease = (trial, y, solved), cost - now
        if best is not None:
            (x, run, s), cost = best, cost - decrease
        if decrease < ENOUGH * cost:
            break
    sensors, run = weighed.sensors(s), model.runs(free, x)[0]
    return Fit(tuple(free), x, sensors, run, sensors.read(run, model.reading_step, model.starts), cost)


def _bounded(hessian: np.ndarray, gradient: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """The step that lowers a quadratic most within bounds."""
    scale = 1.0 / np.sqrt(np.diag(hessian))
    root = np.linalg.cholesky(hessian * scale[:, None] * scale + 1e-10 * np.eye(len(scale)))
    room = np.minimum(low / scale, -1e-12), np.maximum(high / scale, 1e-12)
    return scale * lsq_linear(root.T, solve_triangular(root, scale * gradient, lower=True), bounds=room, method="bvls", max_iter=400).x
