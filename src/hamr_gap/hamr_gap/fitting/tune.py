"""A re-tuned model of a record: as few steps as it bears, drives held or smooth, whichever way it leaves least."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hamr_dynamics.machine import Machine

from ..data.record import Record
from .fit import Fit, explains, fit
from .initial_states import InitialStates
from .model import BAND, Model
from .parameters import CHANGE_SD, Free, changes
from .pieces import FEWEST, telling
from .roles import Roles, mask, roles_of
from .scales import scales_of
from .weighed import Weighed

HELD = 1.2  # by how much less must be left of a drive held between samples, where the driver is known to be faster than that
ASTRAY = 0.2  # of a sensor's motion: a re-tuned free run that is off by more, from an unknown start, is lost, and shorter ones serve
LITTLE = 10.0  # of the noise: what is left of short pieces, up to which longer ones may show more
GROWS = 4.0  # times as far apart, from the first to the last quarter of a piece, that starts may lead: a fit by derivatives is lost beyond
DRIFTS = 8.0  # likewise of starts that are fitted along: a frequency that is off leads 7 times as far, and never away
FEW = 0.1  # of the pieces, in which they may
INERTIAS = (1.0, 0.4, 0.5, 0.63, 0.8, 1.25, 1.6, 2.0, 2.5)  # of the given one, at which a re-tune in pieces may begin
HALF = 0.5  # of the mean square that the given one leaves, from which on it does
TRUST = 0.01  # of what a model leaves: no reading is weighed as if better than that, or no prior would count beside an error of the model


@dataclass(frozen=True)
class Tuned:
    """A re-tuned model: the readings that it is fitted to, the fit, which readings serve what, and whether short runs stand in for free
    ones that went astray."""

    weighed: Weighed
    fit: Fit
    roles: Roles
    shortened: bool = False

    @property
    def rms(self) -> np.ndarray:
        """(channels,) of what is left of the fitted readings."""
        return self.weighed.missed(self.fit.reading) * self.weighed.sigma


def tune(machine: Machine, record: Record, noise: np.ndarray, *, whole: bool = False, held: bool | None = None) -> Tuned:
    """The re-tuned model that leaves least; in short pieces where free runs go astray, or where those lead a free run to a better fit.

    Args:
        noise: (channels,) standard deviation of a sample's noise. whole: whether runs stay as long as they are, astray or not.
        held: whether drives hold between samples; None: whichever leaves less.

    Raises:
        BagError: the record is too short, or the model diverges.
    """
    best = _held_or_smooth(machine, record, noise, held)
    free = not record.rest and not best.weighed.model.starts
    if free and not whole and (best.rms > ASTRAY * np.nanstd(record.readings, axis=0)).any():
        best = replace(_held_or_smooth(machine, record, noise, held, telling(machine, record)), shortened=True)
    if not whole:
        best = _halved(machine, record, noise, held, best)
    if not whole and not record.driven.any():
        best = _doubled(best)
    if not best.weighed.model.starts and not explains(best.weighed, best.fit.reading):
        best = _led_by_pieces(best)
    return best


def _halved(machine: Machine, record: Record, noise: np.ndarray, held: bool | None, best: Tuned) -> Tuned:
    """The re-tuned model in shorter and shorter pieces while it goes astray in them, or what differs a little at their start does: one
    that tips over is soon lost."""
    while best.weighed.initial is not None and _lost(best):
        pieces = best.weighed.model.pieces
        readings = float(np.median(pieces.stop - pieces.first)) / 2.0
        if readings < FEWEST:
            break
        shorter = _held_or_smooth(machine, record, noise, held, readings * best.weighed.model.reading_step)
        best = replace(shorter, shortened=best.shortened)
    return best


def _doubled(best: Tuned) -> Tuned:
    """The re-tuned model in longer and longer pieces, while it follows and leaves little: of what nothing drives, but what slows it down,
    a short piece shows next to nothing, and a long one the sum of it."""
    while best.weighed.missed(best.fit.reading).max() < LITTLE:
        longer = _longer(best)
        if longer is None or _lost(longer):
            break
        best = longer
    return best


def _longer(best: Tuned) -> Tuned | None:
    """In pieces of twice the length, from where it is, and their starts fitted with everything else; None if there are no longer ones."""
    model, found = best.weighed.model, best.fit
    length = 2.0 * float(np.median(model.pieces.stop - model.pieces.first)) * model.reading_step
    twice = replace(model, piece=length, begins=True)
    if len(twice.pieces) >= len(model.pieces):
        return None
    roles = roles_of(twice, model.machine.to_si["T"])
    weighed = replace(best.weighed, model=twice, coarse=twice, chosen=mask(twice, roles.fit), initial=None, shorter=best.weighed)
    return Tuned(weighed, fit(weighed, *twice.with_starts(found.free, found.x)), roles)


def _lost(tuned: Tuned) -> bool:
    """Whether pieces are too long: the model goes astray in them, or what differs a little at their start does."""
    weighed = tuned.weighed
    starts = weighed.initial or InitialStates.about(weighed.model, weighed.model.rows(tuned.fit.free, tuned.fit.x)[0], weighed.sigma)
    most = DRIFTS if weighed.model.begins else GROWS
    return bool(np.quantile(starts.growth, 1.0 - FEW) > most) or _astray(tuned, ASTRAY)


def _astray(tuned: Tuned, share: float) -> bool:
    """Whether some sensor's readings are off, beyond their noise, by more than a share of what they move within a piece."""
    model, chosen = tuned.weighed.model, tuned.weighed.chosen.any(1)
    beyond = np.sqrt(np.maximum(tuned.rms**2 - tuned.weighed.sigma**2, 0.0))
    parts = [model.target[a:b][chosen[a:b]] for a, b in model.pieces.parts]
    motion = np.sqrt(np.mean([np.nanvar(part, axis=0) for part in parts if len(part)], axis=0))
    return bool((beyond > share * motion).any())


def _held_or_smooth(machine: Machine, record: Record, noise: np.ndarray, held: bool | None, piece: float = 0.0) -> Tuned:
    """Between samples a drive was smooth, or held: what fits better was the case."""
    ways = (False, True) if record.drives_per_reading == 1 and record.driven.any() else (True,)
    tried = [_tuned(machine, replace(record, held=way), noise, piece) for way in (ways if held is None else (held,))]

    def surprise(t: Tuned) -> float:
        own = t.weighed.model.record
        return (HELD if own.held and own.hold else 1.0) * float(np.sum((t.rms / noise) ** 2))

    return min(tried, key=surprise)


def _tuned(machine: Machine, record: Record, noise: np.ndarray, piece: float) -> Tuned:
    """With as few steps as it bears, and pieces of T if it is not to choose."""
    mean = max(1, int(1.0 / (record.step * machine.to_si["T"] * BAND)))
    model = Model(machine, record, _coarsest(machine, record), mean, scales_of(machine, record), piece)
    roles = roles_of(model, machine.to_si["T"])
    alone = len(machine.joints) == 1
    gains = tuple(range(1 if alone else 0, len(record.channels)))
    sigma, free = noise / np.sqrt(mean), changes(machine, model.scales, record.driven)
    weighed = Weighed(model, mask(model, roles.fit), sigma, gains, model, initial=InitialStates.about(model, model.neutral, sigma))
    # trusted first, sensors keep a fit from wandering off along scales that only end stops tell apart
    rough = replace(weighed, gains=(), sigma=_trusted(weighed, model.plain))
    found = fit(rough, free, _begun(rough, free))
    weighed = replace(weighed, initial=InitialStates.about(model, model.rows(free, found.x)[0], sigma))
    fair = replace(weighed, sigma=_trusted(weighed, found.reading))
    return Tuned(fair, fit(fair, free, found.x), roles)


def _begun(weighed: Weighed, free: list[Free]) -> np.ndarray:
    """(P,) where a re-tune begins: the model as given, or with another inertia where what it swings by is far off. A frequency that is off
    by more than half a period within a piece leads to a minimum of its own."""
    inertia = np.array([f.sd / CHANGE_SD if f.row.startswith("change.inertia") else 0.0 for f in free])
    tried = (np.array(INERTIAS)[:, None] - 1.0) * inertia
    if not weighed.model.starts:
        return tried[0]
    missed = (weighed.missed(run) for run in weighed.model.runs(free, tried))
    left = [np.mean(seen**2) if len(seen := each[np.isfinite(each)]) else np.inf for each in missed]
    return tried[int(np.argmin(left))] if min(left) < HALF * left[0] else tried[0]


def _trusted(weighed: Weighed, reading: np.ndarray) -> np.ndarray:
    return np.maximum(weighed.sigma, TRUST * weighed.missed(reading) * weighed.sigma)


def _led_by_pieces(tuned: Tuned) -> Tuned:
    """The fit again from where one of short pieces ends, if that is better.

    A run that hits its stops at another time than it did is lost from there on, and fits rest in minima that this makes; pieces do not.
    """
    weighed, found = tuned.weighed, tuned.fit
    begun = fit(weighed.in_pieces, found.free, np.zeros(len(found.x)))
    return replace(tuned, fit=min(found, fit(weighed, found.free, begun.x), key=lambda f: f.cost))


def _coarsest(machine: Machine, record: Record) -> int:
    """Steps per sample with at least 20 of them in a period of the fastest joint."""
    rest = machine.at_rest
    fastest = max(machine.diagonal(rest.stiffness, j) / machine.diagonal(rest.mass, j) for j in range(len(machine.joints)))
    wanted = record.step * np.sqrt(max(fastest, 0.0)) * 20 / (2 * np.pi)
    return record.drives_per_reading * max(1, int(np.ceil(wanted / record.drives_per_reading)))
