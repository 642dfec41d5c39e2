"""How far apart fitted hypotheses are under other drives, beside the record that they were fitted to.

One of two is taken for right: what it would read, of the record and of a run under other drives after it, without noise. What a refit of
the other to both runs leaves of that is what the run shows. Linearly that is done in a moment, of all readings, but a relaxing spring that
takes the part of a creeping drive goes a long way for it, and then the linear picture shows them much further apart than they are; and
what a short run shows may lie where it is not judged.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from hamr_description.errors import BagError

from ..data.record import Record, joined
from ..fitting.corrected import Corrected
from ..fitting.fit import fit
from ..fitting.linear import jacobian
from ..fitting.model import Model
from ..fitting.roles import mask, roles_of
from ..fitting.sensors import Sensors
from ..fitting.weighed import Weighed
from ..naming.blocks import foreseen
from ..naming.hypothesis import BLOCKS, Hypothesis
from ..naming.prepare import Prepared
from .excite import SIGNALS, signals

WITHIN = 0.9  # of the widest motion that was measured: no forecast is so good that an end stop further out is safe
NEAR = 0.01  # of what is left: a refit need not be better known
SMALLER = 8  # times, at most


@dataclass(frozen=True)
class Apart:
    """What a refit leaves: mean squares of readings in units of their noise, of the record and of the run after it.

    Attributes:
        record: zero where the run stands for itself. run. throughout: t by which that is seen in block after block of both.
    """

    record: float
    run: float
    throughout: float = 0.0


def shapes(model: Model, seconds: float, seed: int = 0, names: Sequence[str] = SIGNALS) -> dict[str, np.ndarray]:
    """Name -> (n, joints) drives of signals of `excite` for some seconds, as large as those that were recorded."""
    record = model.record
    per, second = record.drives_per_reading, 1.0 / model.machine.to_si["T"]
    found = signals(model.machine, record.step / per, int(seconds * second / record.step) * per, seed, names)
    return {name: np.abs(record.drives).max(axis=0) * shape for name, shape in found.items()}


def asked(record: Record, drives: np.ndarray) -> Record:
    """A run from rest of the same machine under drives (n, joints); its readings, which nobody knows yet, are zero."""
    readings = np.zeros((len(drives) // record.drives_per_reading, len(record.channels)))
    return replace(record, drives=drives, readings=readings, rest=True, breaks=(), uneven=0.0, shaken=0.0)


def after(prepared: Prepared, run: Record) -> Weighed:
    """A record and a run after it, of which all readings count; that run alone if the record is not from rest, or in pieces."""
    model = prepared.weighed.model
    alone = model.pieces is not None or not model.record.rest
    record = run if alone else joined([model.record, run])
    both = replace(model, record=record)
    coarse = prepared.weighed.coarse and replace(prepared.weighed.coarse, record=record)
    return replace(prepared.weighed, model=both, coarse=coarse, chosen=np.isfinite(both.target), initial=None)


def served(weighed: Weighed) -> tuple[np.ndarray, np.ndarray]:
    """(n, channels) readings of a record and a run after it that will be fitted, and that names will be told apart by, these among them;
    all, where they are too few."""
    try:
        roles = roles_of(weighed.model, weighed.model.machine.to_si["T"])
    except BagError:
        return weighed.chosen, weighed.chosen
    return mask(weighed.model, roles.fit), mask(weighed.model, roles.fit | roles.select)


def within(model: Model, drives: np.ndarray, *rivals: Hypothesis) -> np.ndarray:
    """Drives (n, joints), smaller where a rival would go further than was measured: into end stops, where nothing can be predicted."""
    reach = WITHIN * np.nanmax(np.abs(model.target), axis=0)
    for _ in range(SMALLER):
        run = replace(model, record=asked(model.record, drives))
        moved = [run.runs(h.fit.free, h.fit.x)[0] for h in rivals]
        with np.errstate(invalid="ignore"):
            over = max(float(np.max(np.abs(y) / reach)) if np.isfinite(y).all() else 2.0 for y in moved)
        if over <= 1.0:
            break
        drives = drives / over
    return drives


class Follower:
    """A hypothesis that follows what another one would have read, as well as its parameters and the sensors' let it."""

    def __init__(self, weighed: Weighed, own: int, h: Hypothesis, parts: tuple[np.ndarray, np.ndarray] | None = None) -> None:
        """Of a hypothesis in `weighed`, whose first `own` readings are those of the record; a refit fits and judges all that count, or the
        parts (n, channels) that are `served`."""
        self._weighed, self._own, self._h = weighed, own, h
        self._fitted, self._judged = parts or (weighed.chosen, weighed.chosen)

    @cached_property
    def run(self) -> np.ndarray:
        """(n, channels) that it would have read itself."""
        return self._weighed.model.runs(self._h.fit.free, self._h.fit.x)[0]

    @cached_property
    def _basis(self) -> np.ndarray:
        """(m + P + sensors, P + sensors) orthonormal directions in which parameters and sensors move it, and their priors."""
        weighed, found = self._weighed, self._h.fit
        runs = Corrected(weighed, found.free, found.x, self.run)
        columns = jacobian(weighed, found.free, found.x, self.run, Sensors.none(self.run.shape[1]), runs.near)
        prior = np.zeros(columns.shape[1])
        prior[: len(found.free)] = [1.0 / f.sd for f in found.free]
        matrix = np.vstack([columns, np.diag(prior)])
        return np.linalg.qr(matrix)[0] if np.isfinite(matrix).all() else np.full_like(matrix, np.nan)

    def foreseen(self, truth: np.ndarray) -> Apart:
        """What would be left of readings (n, channels), if all were linear; nothing of a hypothesis that diverges, or of what does."""
        off = self._weighed.vector(truth - self.run)
        left = off - self._basis[: len(off)] @ (self._basis[: len(off)].T @ off)
        return self._of(left, self._weighed.chosen) if np.isfinite(left).all() else Apart(0.0, 0.0)

    def refitted(self, truth: np.ndarray) -> Apart:
        """What is left of readings (n, channels), as a verdict on both runs would find: of those judged, after a refit to those fitted.
        Nothing of a hypothesis that diverges."""
        if not np.isfinite(self.run).all():
            return Apart(0.0, 0.0)
        model = copy(self._weighed.model)
        model.target = np.where(np.isfinite(model.target), truth, np.nan)
        fitted, judged = (replace(self._weighed, model=model, chosen=part) for part in (self._fitted, self._judged))
        found = fit(fitted, self._h.fit.free, self._h.fit.x, tolerance=NEAR)
        return self._of(judged.vector(model.target - found.reading), self._judged)

    def _of(self, left: np.ndarray, told: np.ndarray) -> Apart:
        """Of what is left (m,) of readings `told` (n, channels)."""
        square = np.full(told.shape, np.nan)
        square[told] = left**2
        record, run = square[: self._own], square[self._own :]
        means = [float(np.nanmean(part)) if np.isfinite(part).any() else 0.0 for part in (record, run)]
        both = 2 * BLOCKS  # as many of the readings held out as of the fitted ones
        blocks = [part[np.isfinite(part)] for part in np.array_split(square[told.any(1)], both)]
        return Apart(*means, throughout=foreseen(*zip(*[(block.mean(), block.size) for block in blocks if block.size], strict=True)))
