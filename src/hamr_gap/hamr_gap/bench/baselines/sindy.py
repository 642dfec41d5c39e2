"""Sparse regression (PySINDy's sequentially thresholded least squares) of the residual force on what the library's laws add to it."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hamr_description.errors import ConfigError

from ...fitting.fit import fit
from ...fitting.parameters import Candidate, effect_parameters
from ...naming.candidates import candidates
from ...naming.hypothesis import Hypothesis, judge
from ...naming.prepare import Prepared
from ...naming.screen import Column, screen
from .everything import single_places
from .forces import Forces, forces_of
from .result import Path, Step, together

THRESHOLDS = np.geomspace(0.01, 1.0, 13)  # of the residual's rms that a column must make
RIDGES = (1e-6, 1e-3, 1e-1)
BLOCKS = 24  # of the readings that select
SHARES = np.array([1.0, 0.3, 0.1, 0.03, 0.01])  # of the regression's sizes from which a fit may begin: the best is taken
MOST = 8  # effects that are fitted together


@dataclass(frozen=True)
class Dictionary:
    """Columns at measured states, in units of noise.

    Attributes:
        columns: what each is. places: the candidate at one place that each belongs to. scale: row -> its unit.
        fit, judged: (m, C + 1) columns and, last, the residual, cleared of what a re-tune could do.
    """

    columns: list[Column]
    places: list[Candidate]
    scale: dict[str, float]
    fit: np.ndarray
    judged: np.ndarray


def sindy(prepared: Prepared) -> Path:
    """Names whose columns survive the threshold that is best on held-out readings, ranked by taking them out one by one, the least missed
    first; the level of a name is the log ratio of the held-out errors without and with it. What survives is then fitted as the workflow
    fits."""
    found = dictionary(prepared)
    coefficients = sparse(found)
    alive = {k: found.places[k] for k in np.flatnonzero(coefficients).tolist()}
    ranked, levels = _ranked(found, {k: c.name for k, c in alive.items()})
    share = np.abs(coefficients) * np.linalg.norm(found.fit[:, :-1], axis=0)
    strongest = [max((k for k in alive if alive[k].name == name), key=share.__getitem__) for name in ranked[:MOST]]
    chosen = [together(alive[k] for k in strongest[: count + 1]) for count in range(len(strongest))]
    steps = [Step(t, refit(prepared, found, coefficients, c)) for t, c in zip(levels, chosen, strict=False)]
    return Path(steps, threshold=min((step.level for step in steps), default=0.0))


def _ranked(found: Dictionary, names: dict[int, tuple]) -> tuple[list[tuple], list[float]]:
    """Names of columns, most missed first, and by how much the logarithm of the held-out error rises without each and all behind it."""
    fit_, judged = (np.linalg.qr(x, mode="r") for x in (found.fit, found.judged))

    def error(kept: Sequence[tuple]) -> float:
        chosen = [k for k in names if names[k] in kept]
        x = np.linalg.lstsq(fit_[:, chosen], fit_[:, -1], rcond=None)[0]
        return float(np.sum((judged[:, -1] - judged[:, chosen] @ x) ** 2))

    kept, ranked, levels = sorted(set(names.values())), [], []
    while kept:
        whole = error(kept)
        without = {name: error([other for other in kept if other != name]) for name in kept}
        least = min(kept, key=without.__getitem__)
        kept.remove(least)
        ranked.insert(0, least)
        levels.insert(0, float(np.log(without[least] / whole)))
    return ranked, levels


def dictionary(prepared: Prepared) -> Dictionary:
    """All sizes of all forms at all places, shapes at their screening values."""
    weighed, forces = prepared.weighed, forces_of(prepared)
    wanted = single_places(candidates(weighed.model.machine, weighed.model.record))
    left = weighed.vector(weighed.model.target - prepared.base.fit.reading)
    seen = screen(weighed, prepared.base.fit, wanted, amplitude=float(np.sqrt(np.mean(left**2))))  # for sizes that matter
    scale = {f.row: f.scale for f in effect_parameters(wanted, weighed.model.scales)}
    place = {row: c for c in wanted for row, _ in c.rows(shape=False)}
    rows = [
        forces.rows({row: x * scale[row] for row, x in c.shapes} | {c.row: c.size * scale[c.row]}) for c in seen.columns
    ]  # fmt: skip
    added = forces.added(np.stack(rows))
    for k in [k for k, c in enumerate(seen.columns) if place[c.row].law.acts == "sense"]:
        added[k] = forces.misread(rows[k][None])[0]
    fits = forces.fits
    useful = np.isfinite(added).all((1, 2)) & (np.abs(added[:, fits]).max((1, 2)) > 0)
    columns = [c for c, ok in zip(seen.columns, useful, strict=True) if ok]
    every = np.concatenate([added[useful], forces.residual[None]])
    return Dictionary(columns, [place[c.row] for c in columns], scale, *_cleared(forces, every))


def _cleared(forces: Forces, every: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(m, K) for the readings to fit and to select on, each (K, n, outputs) in noise, less what fits of the nuisance explain."""
    noise, nuisance = forces.noise(), forces.nuisance()
    parts = [(x[:, rows] / noise).reshape(len(x), -1).T.astype(float) for rows in (forces.fits, forces.judges) for x in (every, nuisance)]
    fit_, known, judged, known_judged = parts
    size = np.linalg.norm(known, axis=0)
    share = np.linalg.lstsq(known / size, fit_, rcond=1e-10)[0]
    return fit_ - known / size @ share, judged - known_judged / size @ share


def sparse(found: Dictionary) -> np.ndarray:
    """(C,) coefficients by STLSQ: of all thresholds and ridges the sparsest within one standard error of the best held-out error.

    Raises:
        ConfigError: PySINDy is not installed.
    """
    try:
        from pysindy import STLSQ
    except ImportError:
        raise ConfigError("Sparse regression needs PySINDy, which is not installed: pip install pysindy==2.1.0.") from None
    r = np.linalg.qr(found.fit, mode="r")  # the same least squares in as many rows as columns
    size = np.linalg.norm(r, axis=0)
    usable = size[:-1] > 1e-9 * size.max()
    scaled = r[:, :-1][:, usable] / size[:-1][usable]
    tried = []
    for ridge in RIDGES:
        for threshold in THRESHOLDS:
            optimiser = STLSQ(threshold=threshold, alpha=ridge, max_iter=50)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # "eliminated all coefficients" is an answer
                optimiser.fit(scaled, (r[:, -1] / size[-1])[:, None])
            x = np.zeros(len(usable))
            x[usable] = optimiser.coef_[0] * size[-1] / size[:-1][usable]
            tried.append((_blocks(found.judged[:, -1] - found.judged[:, :-1] @ x), x))
    best = min(tried, key=lambda t: t[0].mean())[0]
    error = best.std(ddof=1) / np.sqrt(len(best))
    return min((t for t in tried if t[0].mean() <= best.mean() + error), key=lambda t: (np.count_nonzero(t[1]), t[0].mean()))[1]


def refit(prepared: Prepared, found: Dictionary, coefficients: np.ndarray, effects: Sequence[Candidate]) -> Hypothesis:
    """Effects fitted to the readings, from the regression's sizes and the shapes of its strongest columns."""
    base = prepared.base.fit
    added = effect_parameters(effects, prepared.weighed.model.scales)
    sizes = {row for c in effects for row, _ in c.rows(shape=False)}
    begin = {}
    for k in np.argsort(np.abs(coefficients) * np.linalg.norm(found.fit[:, :-1], axis=0)):  # the strongest last
        if coefficients[k]:
            begin |= {found.columns[k].row: coefficients[k] * found.columns[k].size, **dict(found.columns[k].shapes)}
    x0 = [begin.get(f.row, f.center) for f in added]
    inside = [x if f.low < x < f.high else f.center or 1e-3 * f.sd for f, x in zip(added, x0, strict=True)]
    weighed, free = prepared.weighed, (*base.free, *added)
    trials = np.concatenate([np.tile(base.x, (len(SHARES), 1)), np.outer(SHARES, inside)], axis=1)
    shapes = [f.row not in sizes for f in added]
    trials[:, len(base.x) :][:, shapes] = np.array(inside)[shapes]
    with np.errstate(over="ignore", invalid="ignore"):
        costs = np.array([weighed.solve_sensors(run)[1] for run in weighed.model.runs(free, trials, weighed.until)])
    return judge(weighed, prepared.judged, effects, fit(weighed, free, trials[np.argmin(np.where(np.isnan(costs), np.inf, costs))]))


def _blocks(left: np.ndarray) -> np.ndarray:
    return np.array([np.mean(part**2) for part in np.array_split(left, BLOCKS)])
