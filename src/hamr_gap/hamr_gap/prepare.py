"""From a record and a machine to a weighed model: how finely to simulate, what counts as noise, which readings serve what."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hamr_description.errors import BagError
from hamr_dynamics.machine import Machine

from .fit import Fit, fit
from .hypothesis import Hypothesis, judge, left_of
from .initial_states import InitialStates
from .model import BAND, Model, scales_of
from .parameters import changes
from .pieces import MANY, telling
from .record import Record, fresh, noise_of
from .roles import Roles, mask, roles_of
from .weighed import Weighed

FINEST = 16  # steps per sample, at most
ENOUGH = 0.2  # of the noise: what halving the step may move
HELD = 1.2
ROUGH = 2.0  # of the noise of a reading: what a fit leaves, from which another start is worth its time
ASTRAY = 0.2  # of a sensor's motion: a re-tuned free run that is off by more, from an unknown start, is lost, and shorter ones serve
TRUST = 0.01  # of what a model leaves: no reading is weighed as if better than that, or no prior would count beside an error of the model


@dataclass(frozen=True)
class Prepared:
    """A record ready to be explained.

    Attributes:
        weighed: fitted readings. judged: readings to select on. roles.
        base: the re-tuned model. raw: mean square of the residual before it, in units of the noise, on the judged readings.
        noise: (channels,) standard deviation of a sample's noise. stale: share of the samples that were old ones, sent again.
    """

    weighed: Weighed
    judged: np.ndarray
    roles: Roles
    base: Hypothesis
    raw: float
    noise: np.ndarray
    stale: float


def prepare(machine: Machine, record: Record, *, noise: np.ndarray | None = None) -> Prepared:
    """Checks a record, chooses step and rate, and re-tunes the model fairly.

    Args:
        noise: (channels,) standard deviation of a sample's noise, if known; estimated otherwise.

    Raises:
        BagError: constant drives or readings, too little data; one sentence.
    """
    _check(machine, record)
    given, record = record, fresh(record)
    # between samples a drive was smooth, or held: what fits better was the case
    noise = noise_of(record.readings) if noise is None else noise
    ways = (False, True) if record.drives_per_reading == 1 and record.driven.any() else (True,)
    weighed, found, roles = _best([_tuned(machine, replace(record, held=held), noise) for held in ways], noise)
    if not record.rest and not weighed.model.starts and (_rms(weighed, found.reading) > ASTRAY * np.nanstd(record.readings, axis=0)).any():
        piece = min(telling(machine), record.span / MANY)
        weighed, found, roles = _best([_tuned(machine, replace(record, held=held), noise, piece) for held in ways], noise)
    if weighed.model.pieces is None and np.max(_rms(weighed, found.reading) / weighed.sigma) > ROUGH:
        found = _led_by_pieces(weighed, found, roles)
    model, substeps = weighed.model, weighed.model.substeps
    while (numerical := _moves(weighed, found)) > ENOUGH and substeps * 2 <= FINEST:
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
    return Prepared(weighed, judged, roles, judge(weighed, judged, (), found), raw, noise, stale)


def _best(tried: Sequence[tuple[Weighed, Fit, Roles]], noise: np.ndarray) -> tuple[Weighed, Fit, Roles]:
    """The re-tuned model that leaves least."""
    return min(tried, key=lambda t: _surprise(t[0].model.record) * np.sum((_rms(t[0], t[1].reading) / noise) ** 2))


def _surprise(record: Record) -> float:
    """By how much less must be left of a drive held between samples, where the driver is known to be faster than that."""
    return HELD if record.held and record.hold else 1.0


def _tuned(machine: Machine, record: Record, noise: np.ndarray, piece: float = 0.0) -> tuple[Weighed, Fit, Roles]:
    """A re-tuned model with as few steps as it bears, and pieces of T if it is not to choose."""
    mean = max(1, int(1.0 / (record.step * machine.to_si["T"] * BAND)))
    model = Model(machine, record, _coarsest(machine, record), mean, scales_of(machine, record), piece)
    roles = roles_of(model, machine.to_si["T"])
    alone = len(machine.joints) == 1
    gains = tuple(i for i, c in enumerate(record.channels) if not alone or machine.channels.index(c) >= 1)
    sigma, free = noise / np.sqrt(mean), changes(machine, model.scales)
    weighed = Weighed(model, mask(model, roles.fit), sigma, gains, model, initial=InitialStates.about(model, model.neutral, sigma))
    # trusted first, sensors keep a fit from wandering off along scales that only end stops tell apart
    rough = replace(weighed, gains=(), sigma=np.maximum(weighed.sigma, TRUST * _rms(weighed, model.plain)))
    found = fit(rough, free, np.zeros(len(free)))
    weighed = replace(weighed, initial=InitialStates.about(model, model.rows(free, found.x)[0], sigma))
    fair = replace(weighed, sigma=np.maximum(weighed.sigma, TRUST * _rms(weighed, found.reading)))
    return fair, fit(fair, free, found.x), roles


def _led_by_pieces(weighed: Weighed, found: Fit, roles: Roles) -> Fit:
    """The fit again from where one of short pieces ends, if that is better.

    A run that hits its stops at another time than it did is lost from there on, and fits rest in minima that this makes; pieces do not.
    """
    parts = replace(weighed.model, piece=telling(weighed.model.machine))
    short = replace(weighed, model=parts, coarse=parts, chosen=mask(parts, roles.fit), initial=None)
    begun = fit(short, found.free, np.zeros(len(found.x)))
    return min(found, fit(weighed, found.free, begun.x), key=lambda f: f.cost)


def _rms(weighed: Weighed, reading: np.ndarray) -> np.ndarray:
    """(channels,) of what a run leaves of the fitted readings."""
    left = np.where(weighed.chosen, weighed.left(reading) * weighed.sigma, np.nan)
    return np.sqrt(np.nanmean(left**2, axis=0))


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


def _coarsest(machine: Machine, record: Record) -> int:
    """Steps per sample with at least 40 of them in a period of the fastest joint."""
    rest = machine.at_rest
    fastest = max(machine.diagonal(rest.stiffness, j) / machine.diagonal(rest.mass, j) for j in range(len(machine.joints)))
    wanted = record.step * np.sqrt(max(fastest, 0.0)) * 40 / (2 * np.pi)
    return record.drives_per_reading * max(1, int(np.ceil(wanted / record.drives_per_reading)))


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
