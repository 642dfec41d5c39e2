"""From a record and a machine to a weighed model: how finely to simulate, what counts as noise."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hamr_description.errors import BagError
from hamr_dynamics.machine import Machine

from ..data.readings import fresh, noise_of, sensor_noise
from ..data.record import Record
from ..fitting.fit import Fit, fit
from ..fitting.roles import Roles, mask
from ..fitting.tune import tune
from ..fitting.weighed import Weighed
from .hypothesis import Hypothesis, judge, left_of

FINEST = 16  # steps per sample, at most
ENOUGH = 0.2  # of the noise: what halving the step may move
SMALL = 0.1  # of what the re-tune leaves beyond the noise: the same, or it would pass for some of what is missing
CHANCE = 0.5  # of the noise of a reading: less than that is left by chance


@dataclass(frozen=True)
class Prepared:
    """A record ready to be explained.

    Attributes:
        weighed: fitted readings. judged: readings to select on. roles.
        base: the re-tuned model. raw: mean square of the residual before it, in units of the noise, on the judged readings.
        noise: (channels,) standard deviation of a sample's noise. stale: share of the samples that were old ones, sent again.
        shortened: whether short runs stand in for free ones that went astray.
    """

    weighed: Weighed
    judged: np.ndarray
    roles: Roles
    base: Hypothesis
    raw: float
    noise: np.ndarray
    stale: float
    shortened: bool


def prepare(
    machine: Machine, record: Record, *, noise: np.ndarray | None = None, whole: bool = False, held: bool | None = None
) -> Prepared:
    """Checks a record, chooses step and rate, and re-tunes the model fairly.

    Args:
        noise: (channels,) standard deviation of a sample's noise, if known; estimated otherwise. whole, held: as of `tune`.

    Raises:
        BagError: constant drives or readings, too little data; one sentence.
    """
    _check(machine, record)
    given, record = record, fresh(record)
    noise = sensor_noise(record) if noise is None else noise
    tuned = tune(machine, record, noise, whole=whole, held=held)
    weighed, found, roles = tuned.weighed, tuned.fit, tuned.roles
    model, substeps = weighed.model, weighed.model.substeps
    while (numerical := _moves(weighed, found)) > _enough(weighed, found) and substeps * 2 <= FINEST:
        substeps *= 2
        model = replace(model, substeps=substeps)
        weighed = replace(weighed, model=model)
        found = fit(weighed, found.free, found.x)
    weighed = replace(weighed, numerical=numerical if np.isfinite(numerical) else 0.0)  # a run that diverges says nothing
    if model.pieces is None:  # coarse steps are late too, so only now
        weighed = weighed.on_time(found.sensors.shift)
        found = fit(weighed, found.free, found.x)
    model, judged = weighed.model, mask(weighed.model, roles.select)
    raw, _ = left_of(weighed, judged, model.plain)
    sigma = np.maximum(weighed.sigma, noise_of(_gaps(weighed.left(found.reading) * weighed.sigma, roles.fit)))
    if (sigma > 1.2 * weighed.sigma).any():  # noise that is not white from sample to sample
        weighed = replace(weighed, sigma=sigma)
        found = fit(weighed, found.free, found.x)
    stale = float(np.mean(np.isnan(record.readings).all(1) & ~np.isnan(given.readings).all(1)))
    return Prepared(weighed, judged, roles, judge(weighed, judged, (), found), raw, noise, stale, tuned.shortened)


def _check(machine: Machine, record: Record) -> None:
    for j, name in enumerate(machine.joints):
        if record.rest and not record.driven[j]:
            raise BagError(f"The drive of {name} is constant, and it begins at rest: nothing can be said about it; excite it.")
    for c, name in enumerate(record.channels):
        known = record.readings[:, c][np.isfinite(record.readings[:, c])]
        if len(known) < 100 or np.ptp(known) == 0:
            raise BagError(f"The sensor of {name} reads the same all the time, or nothing: check it.")


def _gaps(x: np.ndarray, part: np.ndarray) -> np.ndarray:
    """Readings of a role, with NaN elsewhere, so that differences do not bridge its breaks."""
    return np.where(part[:, None], x, np.nan)


def _enough(weighed: Weighed, found: Fit) -> float:
    """What halving the step may move, in units of a sample's noise."""
    beyond = np.sqrt(max(float(np.mean(weighed.missed(found.reading) ** 2)) - 1.0, CHANCE**2) / weighed.model.mean)
    return min(ENOUGH, SMALL * beyond)


def _moves(weighed: Weighed, found: Fit) -> float:
    """Rms by which halving the step moves the fitted readings, beside the sensors, in units of a sample's noise; inf if it diverges."""
    finer = replace(weighed, model=replace(weighed.model, substeps=2 * weighed.model.substeps))
    run = finer.model.runs(found.free, found.x)[0]
    if not np.isfinite(run).all():
        return np.inf
    moved = weighed.vector(run - found.run)
    columns = weighed.sensor_columns(weighed.moved(found.run, found.sensors.shift))
    moved = moved - columns @ np.linalg.lstsq(columns, moved, rcond=None)[0]
    return float(np.sqrt(np.mean(moved**2)) / np.sqrt(weighed.model.mean))
