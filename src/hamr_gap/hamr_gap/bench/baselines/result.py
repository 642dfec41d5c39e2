"""What every baseline writes: the verdict file that `bench.score` reads, and the answers it would give at other thresholds."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ...fitting.parameters import Candidate
from ...fitting.roles import mask
from ...judging.analyse import SIGNIFICANT
from ...naming.blocks import better
from ...naming.hypothesis import Hypothesis, judge, left_of
from ...naming.prepare import Prepared
from ...naming.tried import noise_floor


@dataclass(frozen=True)
class Step:
    """An answer that a method gives where its threshold is at most `level`; of several, the last.

    Attributes:
        level: evidence, in the method's own measure.
        hypothesis: the model with it. named: False for a model without names.
    """

    level: float
    hypothesis: Hypothesis
    named: bool = True


@dataclass(frozen=True)
class Path:
    """All answers of a method to one record, each with one effect more, and its own threshold."""

    steps: Sequence[Step]
    threshold: float


def result(prepared: Prepared, path: Path) -> dict:
    """The verdict file.

    Besides what `bench.solve` writes: `threshold`, `nothing` (the verdict where no answer reaches it), and `path`: for each answer its
    level, its effects (None: without names), what it leaves on the judged readings and on those of role `report`.
    """
    least = min([prepared.base, *(step.hypothesis for step in path.steps)], key=lambda h: h.left)
    floor = noise_floor(prepared.weighed, least)
    written = {
        "threshold": path.threshold, "nothing": _nothing(prepared), "base": prepared.base.left, "floor": floor, "raw": prepared.raw,
        "numerical": prepared.weighed.numerical, "untouched": _report(prepared, prepared.base),
        "path": [
            {"level": step.level, "effects": _named(prepared, step), "left": h.left, "report": _report(prepared, h)}
            for step in path.steps for h in (step.hypothesis,)
        ],
    }  # fmt: skip
    return written | at(written, path.threshold)


def at(written: dict, threshold: float) -> dict:
    """The answer of a verdict file at another threshold: verdict, weights, and what it leaves."""
    reached = [step for step in written["path"] if step["level"] >= threshold]
    if not reached:
        return {"verdict": written["nothing"], "weights": [], "best": written["base"], "report": written["untouched"]}
    last = reached[-1]
    gap = max(written["base"] - written["floor"], 1e-12)
    share = max(last["left"] - written["floor"], 0.0) / gap
    verdict = "unknown" if last["effects"] is None else "named"
    weights = [{"effects": last["effects"], "left": share, "probability": 1.0}]
    return {"verdict": verdict, "weights": weights, "best": last["left"], "report": last["report"]}


def together(found: Iterable[Candidate]) -> tuple[Candidate, ...]:
    """Effects at single places as one candidate for each name: in the form that comes first, at all its joints."""
    first: dict[str, Candidate] = {}
    joints: dict[str, set[int]] = {}
    for c in found:
        first.setdefault(c.effect, c)
        joints.setdefault(c.effect, set()).update(c.joints)
    return tuple(Candidate(c.effect, c.form, c.joints if c.law.acts == "pair" else tuple(sorted(joints[c.effect]))) for c in first.values())


def _named(prepared: Prepared, step: Step) -> list | None:
    joints = prepared.weighed.model.machine.joints
    return [[c.effect, c.form, [joints[j] for j in c.joints]] for c in step.hypothesis.effects] if step.named else None


def _report(prepared: Prepared, h: Hypothesis) -> dict[str, float]:
    """Mean squares on readings that nothing has used: of the re-tune, of a hypothesis, and of noise alone."""
    weighed = prepared.weighed
    rows = mask(weighed.model, prepared.roles.report)
    base, best = (judge(weighed, rows, (), x.fit) for x in (prepared.base, h))
    return {"base": base.left, "best": best.left, "floor": noise_floor(weighed, best)}


def _nothing(prepared: Prepared) -> str:
    """What the workflow says where no effect is found."""
    _, blocks = left_of(prepared.weighed, prepared.judged, prepared.weighed.model.plain)
    return "parameters_only" if better(blocks, prepared.base.blocks) > SIGNIFICANT else "no_significant_gap"


def falling(levels: Iterable[float]) -> list[float]:
    """Each level no higher than those before it."""
    return np.minimum.accumulate(list(levels)).tolist()
