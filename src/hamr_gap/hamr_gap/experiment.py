"""What would decide between two names: the drive signal under which each, refitted, explains the other least.

Both fitted rivals are simulated under every signal of `excite`. What a refit of one to the other would still do is projected out
linearly. What is left is put beside what the record has shown already, and weighed as the verdict on both runs will weigh it: laws of
one name differ, so a run must show more than its noise would ask for.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .excite import signals
from .fit import Fit
from .hypothesis import Hypothesis
from .linear import jacobian
from .model import Model
from .prepare import Prepared
from .sensors import Sensors
from .weigh import COVERAGE, SHARPNESS, least_told

TRIED_S = 4.0  # of each signal
DECISIVE = 2.0 * np.log(COVERAGE / (1.0 - COVERAGE))  # log odds that the run must add, whichever name is right and however likely now
LENGTHS_S = np.geomspace(4.0, 120.0, 16)  # a record needs 4 s to be divided
SMALLER = 8  # times, at most


@dataclass(frozen=True)
class Shown:
    """What a signal shows of an effect: mean squares of readings, in units of their noise.

    Attributes:
        signature: beyond what a re-tune can do. apart: beyond what the rival can do.
    """

    signature: float
    apart: float


@dataclass(frozen=True)
class Proposal:
    """An experiment.

    Attributes:
        signal: name; empty if none decides. seconds: that decide. odds: name -> log odds that the longest run adds at least.
        d_prime: name -> distance of the rivals after a refit in `TRIED_S`, in units of the noise.
        drives: (n, joints) U, deviations about neutral, at the record's step.
    """

    signal: str
    seconds: float
    odds: dict[str, float]
    d_prime: dict[str, float]
    drives: np.ndarray

    def as_dict(self, rivals: tuple[str, str]) -> dict:
        """As in `verdict.json`."""
        between = f"between {rivals[0]} and {rivals[1]}"
        sentence = (
            f"{self.signal} for {self.seconds:.0f} s would decide {between}." if self.signal
            else f"no drive signal within the limits decides {between} with these sensors; "
                 "another sensor, a load, a known added mass or closed loop may."
        )  # fmt: skip
        return {
            "rivals": list(rivals), "signal": self.signal, "seconds": self.seconds, "odds": self.odds, "d_prime": self.d_prime,
            "sentence": sentence,
        }  # fmt: skip


def propose(prepared: Prepared, first: Hypothesis, second: Hypothesis, *, floor: float, seed: int = 0) -> Proposal:
    """The shortest experiment between two fitted hypotheses, within the largest drives and the widest motion that were measured.

    Args:
        floor: mean square that noise leaves, as `weigh.floor_of` takes it. seed: of noise in the signals.
    """
    model = prepared.weighed.model
    machine, record = model.machine, model.record
    step = record.step / record.drives_per_reading
    limit = np.abs(record.drives).max(axis=0)
    ways = ((first, second), (second, first))
    known = max(min(first.left, second.left) - floor, 0.0)
    odds, d_prime = {}, {}
    for name, shape in signals(machine, step, _samples(prepared, TRIED_S), seed).items():
        driven = _driven(model, _within(model, limit * shape, first, second))
        shown = [_shown(driven, prepared, *pair) for pair in ways]
        odds[name] = np.min([_odds(prepared, floor, known, s) for s in shown], axis=0)
        d_prime[name] = float(np.sqrt(min(s.apart for s in shown) * driven.target.size))
    enough = {name: int(np.argmax(x >= DECISIVE)) for name, x in odds.items() if x.max() >= DECISIVE}
    said = {name: float(x[-1]) for name, x in odds.items()}
    if not enough:
        return Proposal("", 0.0, said, d_prime, np.empty((0, len(machine.joints))))
    best = min(enough, key=lambda name: (enough[name], -odds[name][enough[name]]))
    seconds = float(LENGTHS_S[enough[best]])
    drives = _within(model, limit * signals(machine, step, _samples(prepared, seconds), seed)[best], first, second)
    return Proposal(best, seconds, said, d_prime, drives)


def _samples(prepared: Prepared, seconds: float) -> int:
    model = prepared.weighed.model
    per = model.record.drives_per_reading
    return int(seconds / model.machine.to_si["T"] / model.record.step) * per


def _driven(model: Model, drives: np.ndarray) -> Model:
    record = model.record
    readings = np.zeros((len(drives) // record.drives_per_reading, len(record.channels)))
    return replace(model, record=replace(record, drives=drives, readings=readings, rest=True, breaks=(), held=False))


def _within(model: Model, drives: np.ndarray, *rivals: Hypothesis) -> np.ndarray:
    """Drives, smaller where a rival would go further than was measured: into end stops, where nothing can be predicted."""
    reach = np.nanmax(np.abs(model.target), axis=0)
    for _ in range(SMALLER):
        driven = _driven(model, drives)
        runs = [driven.runs(h.fit.free, h.fit.x)[0] for h in rivals]
        with np.errstate(invalid="ignore"):
            over = max(float(np.max(np.abs(y) / reach)) if np.isfinite(y).all() else 2.0 for y in runs)
        if over <= 1.0:
            break
        drives = drives / over
    return drives


def _shown(model: Model, prepared: Prepared, right: Hypothesis, wrong: Hypothesis) -> Shown:
    """What a model's drives show if one of two hypotheses is right; a rival that diverges under them shows nothing."""
    truth = model.runs(right.fit.free, right.fit.x)[0]
    return Shown(*(_beyond(model, prepared, truth, other.fit) for other in (prepared.base, wrong)))


def _beyond(model: Model, prepared: Prepared, truth: np.ndarray, found: Fit) -> float:
    """Mean square, in units of the noise, of what a refit of a model does not follow of readings (n, channels)."""
    run = model.runs(found.free, found.x)[0]
    weighed = replace(prepared.weighed, model=model, chosen=np.ones_like(truth, bool), initial=None)
    columns = jacobian(weighed, found.free, found.x, run, Sensors.none(truth.shape[1]))
    ridge = np.zeros(columns.shape[1])
    ridge[: len(found.free)] = [1.0 / f.sd for f in found.free]
    apart = np.r_[weighed.vector(truth - run), np.zeros(len(ridge))]
    matrix = np.vstack([columns, np.diag(ridge)])
    if not (np.isfinite(matrix).all() and np.isfinite(apart).all()):
        return 0.0
    left = apart - matrix @ np.linalg.lstsq(matrix, apart, rcond=None)[0]
    return float(np.mean(left[: truth.size] ** 2))


def _odds(prepared: Prepared, floor: float, known: float, shown: Shown) -> np.ndarray:
    """(lengths,) log odds for the right one of two names that the record and runs of `LENGTHS_S` make together.

    Args:
        known: mean square above the floor that either leaves of the record; the right one's law leaves the same share of new runs.
    """
    model = prepared.weighed.model
    share = LENGTHS_S / (model.record.span * model.machine.to_si["T"] + LENGTHS_S)
    before = max(prepared.base.left - floor, 1e-12)
    law = known / before * shown.signature
    gap, left, rival = ((1.0 - share) * a + share * b for a, b in ((before, shown.signature), (known, law), (known, law + shown.apart)))
    least = least_told(gap, prepared.judged.sum() / (1.0 - share))
    return SHARPNESS * np.log((rival / gap + least) / (left / gap + least))
