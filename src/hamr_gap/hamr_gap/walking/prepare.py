"""What comes before any name: segments in their roles, steps that are fine enough, and a fair re-tune."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..fitting.parameters import Free
from ..fitting.weighed import SMALLEST
from .fit import SETTLED, Fit, fit, kept, limited
from .followed import followable
from .left import Judged, floors, left_of, trimmed
from .replay import Replay
from .robot import Numerics, Robot
from .roles import roles
from .segments import CHANGES, Segments, segments
from .setting import Setting, retune
from .starts import Started, best_start, start
from .walk import Walk

LENGTH_MS = 20.0  # of a segment: what acts on the body shows as the square of time, but contact stays predictable for so long only
GROWING_MS = (8.0, LENGTH_MS)
SETTLING = 5  # times that a fit is taken up again, while it leaves clearly less than before
BRIEFLY = 1  # times on short segments, which only lead to the long ones
SLIPS = (1.0, 0.1)  # slip speeds below which friction is viscous, as shares of the model's: the data choose
FINE, HALVED = 0.2, 0.5  # rms in noise by which halving the step may move readings, and how much less the next halving does


@dataclass(frozen=True)
class Prepared:
    """A walk and the re-tuned robot.

    Attributes:
        parts: role -> replay. starts: role -> starts under the re-tuned model. raw, base: the model as given, and re-tuned.
        numerical: rms by which finer steps move readings, in units of noise. floor: mean square that noise leaves.
        worse: times the sensors' noise that readings count as, for starts cannot be told better.
    """

    parts: dict[str, Replay]
    starts: dict[str, Started]
    raw: Judged
    base: Judged
    numerical: float
    floor: float
    worse: float

    @property
    def least(self) -> float:
        """Mean square that counts as a gap: more than the simulation's own error, and a quarter of a sample's noise."""
        return max(self.parts["fit"].observed.mean * SMALLEST**2, (0.5 * self.numerical) ** 2)

    @property
    def gap(self) -> bool:
        """Whether the re-tuned model leaves that much beside the noise, in all readings or in a part of them."""
        replay, begun = self.parts["select"], self.starts["select"]
        noise = floors(replay, replay.slopes(begun.change, begun.residual, self.base.fit.model))
        return bool(max(self.base.left - self.floor, *(self.base.parts - noise)) > self.least)

    def from_(self, other: Fit) -> Prepared:
        """The same re-tuned from where a fit with effects has it, if that leaves less: an effect must not win by a better re-tune."""
        replay, free = self.parts["fit"], self.base.fit.free
        tuned = settled(replay, fit(replay, free, other.x[: len(free)], (), other.change))
        if tuned.cost >= self.base.fit.cost:
            return self
        starts = {role: best_start(self.parts[role], tuned.model, begun.change) for role, begun in self.starts.items()}
        return replace(self, base=Judged((), tuned, *left_of(self.parts["select"], starts["select"])), starts=starts)

    @property
    def coarse(self) -> bool:
        """Whether half the step would move readings by more than noise hides."""
        return self.numerical > FINE

    def finer(self) -> Prepared:
        """The same in half the steps, the re-tune as it is but for the starts; `from_` its own fit, it is fitted anew."""
        robot, tuned = self.parts["fit"].robot.finer(), self.base.fit
        parts = {role: Replay.of(robot, part.segments) for role, part in self.parts.items()}
        begun = start(parts["fit"], tuned.model, tuned.change)
        tuned = replace(tuned, change=begun.change, residual=begun.residual, cost=limited(begun.residual))
        starts = {role: start(parts[role], tuned.model, begun.change) for role, begun in self.starts.items()}
        raw = start(parts["select"], Setting(), self.raw.fit.change)
        return _prepared(parts, tuned, starts, raw, HALVED * self.numerical, self.worse)

    def judge(self, role: str, model: Setting) -> tuple[float, np.ndarray, np.ndarray]:
        """What a model leaves of a role's readings (`left_of`), its starts fitted on from those of the re-tuned one."""
        return left_of(self.parts[role], start(self.parts[role], model, self.starts[role].change))


def prepare(backend: str, walk: Walk, report: Callable[[str], None]) -> Prepared:
    """Re-tunes a backend to a walk.

    Raises:
        BagError: the walk cannot be used; one sentence.
    """
    report("re-tune")
    walk, worse = followable(Robot(backend), walk, LENGTH_MS)
    whole = segments(walk, length_ms=LENGTH_MS, every_ms=LENGTH_MS)
    part = roles(whole)
    free, some = retune(Robot(backend).rest()), whole.some(part["fit"])
    robots = [Robot(backend, Numerics(1, slip)) for slip in SLIPS]
    brief = [(robot, _tuned(robot, some, free, GROWING_MS[:1])[1]) for robot in robots]
    robot, found = min(brief, key=lambda tried: tried[1].cost)
    replay, tuned = _tuned(robot, some, free, GROWING_MS[1:], found)
    parts = {"fit": replay} | {role: Replay.of(replay.robot, whole.some(part[role])) for role in ("select", "calibrate", "report")}
    starts = {role: start(parts[role], tuned.model) for role in ("select", "calibrate")}
    raw = start(parts["select"], Setting())
    return _prepared(parts, tuned, starts, raw, _moved_by(replay, tuned), worse)


def _prepared(
    parts: dict[str, Replay], tuned: Fit, starts: dict[str, Started], raw: Started, numerical: float, worse: float
) -> Prepared:  # fmt: skip
    nothing = Fit((), np.zeros(0), (), raw.change, raw.residual, 0.0, np.zeros((0, 0)))
    plain, base = (Judged((), f, *left_of(parts["select"], begun)) for f, begun in ((nothing, raw), (tuned, starts["select"])))
    return Prepared(parts, starts, plain, base, numerical, 1.0 - CHANGES / parts["fit"].observed.readings, worse)


def _tuned(robot: Robot, some: Segments, free: Sequence[Free], lengths_ms: Sequence[float], found: Fit | None = None) -> tuple[Replay, Fit]:
    """A re-tune, from an earlier one if there is, on segments that grow: under a model that is far off, long ones lead astray."""
    for ms in lengths_ms:
        times = SETTLING if ms == LENGTH_MS else BRIEFLY
        replay = Replay.of(robot, replace(some, samples=round(ms / some.walk.step)))
        x, change = (found.x, found.change) if found else (np.zeros(len(free)), start(replay, Setting()).change)
        found = settled(replay, fit(replay, free, x, (), change), times)
    return replay, found


def settled(replay: Replay, found: Fit, times: int = SETTLING) -> Fit:
    """A fit taken up again from better starts until that helps no more: feet may have started where only a wrong model puts them."""
    for _ in range(times):
        again = fit(replay, found.free, found.x, found.effects, best_start(replay, found.model, found.change).change)
        before, found = found, kept(found, again)
        if again.cost > SETTLED * before.cost:
            break
    return found


def _moved_by(replay: Replay, tuned: Fit) -> float:
    """Rms by which half the steps move readings, in units of noise, once the starts have followed."""
    away = Replay.of(replay.robot.finer(), replay.segments).each(tuned.change, [tuned.model])[0] - tuned.residual
    slopes = replay.slopes(tuned.change, tuned.residual, tuned.model)
    own = np.linalg.solve(slopes.transpose(0, 2, 1) @ slopes, slopes.transpose(0, 2, 1) @ away[..., None])
    return float(np.sqrt(trimmed((away - (slopes @ own)[..., 0])[:, :-CHANGES])[0]))
