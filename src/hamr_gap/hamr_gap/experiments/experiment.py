"""What would decide between names: the drive signal that each explains least, refitted to the record and the run, where another is right.

Signals of `excite` are looked at linearly first, and the shortest run that seems to decide is looked at in earnest (`apart`): one that
does not is made longer, or another is taken. What it shows is weighed as the verdict on both runs will weigh it: laws of one name differ,
so a run must show more than its noise would ask for, and throughout.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np

from ..judging.told_apart import by_all
from ..judging.weigh import COVERAGE, floor_of, least_told, log_odds
from ..naming.blocks import THROUGHOUT
from ..naming.hypothesis import Hypothesis
from ..naming.prepare import Prepared
from ..naming.tried import FLOOR_ERROR
from .apart import Apart, Follower, after, asked, served, shapes, within

LENGTHS_S = np.geomspace(4.5, 60.0, 8)  # a run is divided into fitted and judged readings of its own if 4 s of it serve
TRIED_S = LENGTHS_S[0]  # of each signal, at first
DECISIVE = 2.0 * np.log(COVERAGE / (1.0 - COVERAGE))  # log odds that both runs must make, whichever name is right and however likely now
SURELY = THROUGHOUT + 1.0  # t over blocks to be expected, for it to be above `THROUGHOUT` in most runs
LOOKS = 3  # in earnest, at runs longer than `TRIED_S`


@dataclass(frozen=True)
class Proposal:
    """An experiment.

    Attributes:
        names: how many of the names, from the first on, it decides between. signal: name; empty if none decides. seconds: that decide.
        odds: signal -> log odds that it is foreseen to make in the longest time, for any of the names. d_prime: signal -> distance of the
            nearest two, in units of the noise, in `TRIED_S`; both linearly, of those not looked at in earnest.
        drives: (n, joints) U, deviations about neutral, at the record's step.
    """

    names: int
    signal: str
    seconds: float
    odds: dict[str, float]
    d_prime: dict[str, float]
    drives: np.ndarray

    def as_dict(self, rivals: Sequence[str]) -> dict:
        """As in `verdict.json`."""
        rivals = rivals[: self.names]
        between = f"between {', '.join(rivals[:-1])} and {rivals[-1]}"
        sentence = (
            f"{self.signal} for {self.seconds:.0f} s would decide {between}." if self.signal
            else f"no drive signal within the limits decides {between} with these sensors; "
                 "another sensor, a load, a known added mass or closed loop may."
        )  # fmt: skip
        return {
            "rivals": list(rivals), "signal": self.signal, "seconds": self.seconds, "odds": self.odds, "d_prime": self.d_prime,
            "sentence": sentence,
        }  # fmt: skip


def propose(prepared: Prepared, rivals: Sequence[Sequence[Hypothesis]], *, noise: float, seed: int = 0) -> Proposal:
    """The shortest experiment between fitted names, as many of them as one decides, within the drives and the motion that were measured.

    Args:
        rivals: two names or more, each as the forms that do about as well, the best first.
        noise: mean square that noise alone leaves, as estimated. seed: of noise in the signals.
    """
    for count in range(len(rivals), 1, -1):
        proposal = _Choice(prepared, rivals[:count], noise, seed).shortest()
        if proposal.signal:
            break
    return proposal


@dataclass(frozen=True)
class _Pair:
    """One of two names taken for right, the forms of the other, and what a run shows that a re-tune, and the other, cannot follow."""

    right: Follower
    wrong: Sequence[Follower]
    retuned: Apart
    apart: Apart

    def in_earnest(self) -> _Pair:
        there = np.isfinite(self.right.run).all()
        return replace(self, apart=_least(form.refitted(self.right.run) for form in self.wrong) if there else Apart(0.0, 0.0))


@dataclass(frozen=True)
class _Run:
    """A signal of some seconds: its drives, and every two names under them."""

    seconds: float
    drives: np.ndarray
    pairs: list[_Pair]


class _Choice:
    """The choice of a signal that decides between all of some names."""

    def __init__(self, prepared: Prepared, rivals: Sequence[Sequence[Hypothesis]], noise: float, seed: int) -> None:
        model = prepared.weighed.model
        self._prepared, self._rivals, self._seed, self._second = prepared, rivals, seed, 1.0 / model.machine.to_si["T"]
        self._own = model.record.span / self._second  # s
        base, *right = (by_all(prepared.weighed, prepared.judged, h) for h in (prepared.base, *(forms[0] for forms in rivals)))
        floor = floor_of(noise, right)
        self._count = int(prepared.judged.sum() + prepared.weighed.chosen.sum())
        self._before = max(base.left - floor, 1e-12)
        self._known = max(min(h.left for h in right) - floor, 0.0)
        chance = 2.0 * np.sqrt(2.0 / self._count)  # two standard deviations of a mean square of noise
        self._law = max(self._known - chance, 0.0) / self._before

    def shortest(self) -> Proposal:
        """The shortest run of all signals that decides, the more decided of two as short."""
        runs = {name: self._foreseen(drives) for name, drives in shapes(self._prepared.weighed.model, TRIED_S, self._seed).items()}
        count = self._prepared.weighed.sigma.size * TRIED_S * self._second / self._prepared.weighed.model.reading_step
        d_prime = {name: float(np.sqrt(count * min(pair.apart.run for pair in run.pairs))) for name, run in runs.items()}
        earnest, looks, waiting = set(), 0, []
        for name, run in runs.items():
            self._wait(waiting, name, run, 0.0)
        while waiting and looks < LOOKS:
            seconds, _, name = heapq.heappop(waiting)
            if name in earnest:  # nothing is worth a long run that a short one does not say so in earnest
                runs[name] = self._longer(name, seconds, runs[name])
                looks += 1
            earnest.add(name)
            if self._settles(run := runs[name]):
                return self._proposal(runs, d_prime, name)
            self._wait(waiting, name, run, run.seconds)
        return self._proposal(runs, d_prime, "")

    def _settles(self, run: _Run) -> bool:
        """Whether a run decides in earnest, whichever name is right: looked at as far as the first pair that it does not decide."""
        for k in sorted(range(len(run.pairs)), key=lambda k: self._odds(run.pairs[k], run.seconds)):
            run.pairs[k] = run.pairs[k].in_earnest()
            if self._odds(run.pairs[k], run.seconds, surely=True) < DECISIVE:
                return False
        return True

    def _proposal(self, runs: Mapping[str, _Run], d_prime: dict[str, float], name: str) -> Proposal:
        odds = {name: min(self._odds(pair, LENGTHS_S[-1]) for pair in run.pairs) for name, run in runs.items()}
        nothing = np.empty((0, len(self._prepared.weighed.model.machine.joints)))
        seconds, drives = (runs[name].seconds, runs[name].drives) if name else (0.0, nothing)
        return Proposal(len(self._rivals), name, seconds, odds, d_prime, drives)

    def _wait(self, waiting: list, name: str, run: _Run, tried: float) -> None:
        """Puts a signal among those waiting to be looked at, with the shortest length beyond one tried that seems to decide."""
        for seconds in LENGTHS_S[tried < LENGTHS_S]:
            if (odds := min(self._odds(pair, seconds) for pair in run.pairs)) >= DECISIVE:
                heapq.heappush(waiting, (float(seconds), -odds, name))
                break

    def _foreseen(self, drives: np.ndarray) -> _Run:
        """A signal tried, linearly."""
        drives, base, followers = self._played(drives)
        return _Run(TRIED_S, drives, [
            _Pair(right, wrong, base.foreseen(right.run), _least(form.foreseen(right.run) for form in wrong))
            for (right, *_), wrong in permutations(followers, 2)
        ])  # fmt: skip

    def _longer(self, name: str, seconds: float, known: _Run) -> _Run:
        """A signal for longer, taken to show as much in each second."""
        drives, _, followers = self._played(shapes(self._prepared.weighed.model, seconds, self._seed, (name,))[name])
        pairs = zip(permutations(followers, 2), known.pairs, strict=True)
        return _Run(seconds, drives, [replace(pair, right=right, wrong=wrong) for ((right, *_), wrong), pair in pairs])

    def _played(self, drives: np.ndarray) -> tuple[np.ndarray, Follower, list[list[Follower]]]:
        """Drives, smaller if need be, and what follows under them: the re-tuned model, and each form of each name."""
        prepared, record = self._prepared, self._prepared.weighed.model.record
        drives = within(prepared.weighed.model, drives, *(forms[0] for forms in self._rivals))
        both = after(prepared, run := asked(record, drives))
        own, parts = len(both.model.target) - len(run) // both.model.mean, served(both)

        def follower(h: Hypothesis) -> Follower:
            return Follower(both, own, h, parts)

        return drives, follower(prepared.base), [[follower(h) for h in forms] for forms in self._rivals]

    def _odds(self, pair: _Pair, seconds: float, *, surely: bool = False) -> float:
        """Log odds for the right one of two names that the record and such a run of some seconds make together.

        What the right one leaves of the record, as a share of the gap and beyond chance, its law leaves of the run.

        Args:
            surely: less the error of the noise, where the other name would not be seen to be worse throughout.
        """
        share, apart = self._new(seconds), pair.apart
        gap = (1.0 - share) * self._before + share * pair.retuned.run
        error = FLOOR_ERROR if self._known else 0.0  # which more readings have to share
        law = max((1.0 - share) * (self._known + error) + share * self._law * pair.retuned.run - error, 0.0)
        rival = (1.0 - share) * apart.record + share * apart.run
        if surely and apart.throughout < SURELY:
            rival = max(0.0, rival - FLOOR_ERROR)
        least = least_told(gap, self._count / (1.0 - share))
        return float(log_odds(law / gap, least) - log_odds((law + rival) / gap, least))

    def _new(self, seconds: float) -> float:
        """Share of a run of some seconds in all that is measured then."""
        return seconds / (self._own + seconds)


def _least(found: Iterable[Apart]) -> Apart:
    return min(found, key=lambda apart: apart.record + apart.run)
