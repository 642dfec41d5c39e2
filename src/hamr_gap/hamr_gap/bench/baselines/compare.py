"""The workflow against baselines on the same cases, in pairs, each baseline at the threshold that gives it the workflow's false alarms.

python -m hamr_gap.bench.baselines.compare --out out/gap_bench --cases 100000 130000 --workflow verdicts --baselines stepwise sindy
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import tyro
from scipy.stats import binomtest

from hamr_description.errors import ConfigError, HamrError

from ..rates import rate
from ..score import Scored, names, scored
from .result import at

ALARMS = ("named", "ambiguous", "unknown")
GAP = 1.5  # times the floor that a re-tuned model must leave, or there is nothing to close


@dataclass(frozen=True)
class Pairs:
    """Two methods on the same cases: how often each is right, and alone right; p of the exact McNemar test."""

    both: int
    first_alone: int
    second_alone: int
    neither: int

    @classmethod
    def of(cls, first: Sequence[bool], second: Sequence[bool]) -> Pairs:
        """Counts of paired outcomes."""
        a, b = np.array(first, bool), np.array(second, bool)
        return cls(int((a & b).sum()), int((a & ~b).sum()), int((~a & b).sum()), int((~a & ~b).sum()))

    @property
    def p(self) -> float:
        """Two-sided probability of a difference as large if both were equally good."""
        return sign_p(self.first_alone, self.second_alone)


def sign_p(more: int, less: int) -> float:
    """Exact two-sided sign test; pairs that are equal say nothing."""
    return float(binomtest(more, more + less, 0.5).pvalue) if more + less else 1.0


def alarm(case: Scored) -> bool:
    """Whether something is said to be missing."""
    return case.verdict in ALARMS


def equal_threshold(nulls: Sequence[Scored], allowed: int) -> float:
    """The lowest threshold at which a method raises no more than so many false alarms."""
    levels = sorted((max((step["level"] for step in case.result.get("path", ())), default=-np.inf) for case in nulls), reverse=True)
    return float(np.nextafter(levels[allowed], np.inf)) if allowed < len(levels) else -np.inf


def at_threshold(case: Scored, threshold: float) -> Scored:
    """A baseline's case at another threshold; one that was refused as it is."""
    if "path" not in case.result:
        return case
    answer = at(case.result, threshold)
    answers = tuple(None if w["effects"] is None else names(w["effects"]) for w in answer["weights"])
    return replace(case, verdict=answer["verdict"], first=answers[0] if answers else None, answers=answers, result=case.result | answer)


def somewhere(case: Scored) -> bool:
    """Whether a baseline is exact at some threshold: no more can be had from its ranking, had it known when to stop."""
    return any(at_threshold(case, step["level"]).exact for step in case.result.get("path", ()))


def closed(case: Scored) -> float | None:
    """Share of the re-tuned gap that the answer closes on readings that nothing has used, zero where nothing is said; None where there is
    no gap to close."""
    if "report" not in case.result:
        return None
    base, best, floor = (case.result["report"][k] for k in ("base", "best", "floor"))
    return (base - best) / (base - floor) if base > GAP * floor else None


def rows(workflow: Sequence[Scored], baseline: Sequence[Scored]) -> list[tuple[str, str, str, str]]:
    """What, of the workflow, of the baseline at equal false alarms, and the paired difference."""
    nulls = [i for i, case in enumerate(workflow) if case.group == "null"]
    known = [i for i, case in enumerate(workflow) if case.group in ("single", "pair", "triple")]
    threshold = equal_threshold([baseline[i] for i in nulls], sum(alarm(workflow[i]) for i in nulls))
    equal = [at_threshold(case, threshold) for case in baseline]
    shares = [(closed(workflow[i]), closed(equal[i])) for i in known]
    shares = [(a, b) for a, b in shares if a is not None and b is not None]

    def counted(what: str, first: Sequence[bool], second: Sequence[bool]) -> tuple[str, str, str, str]:
        pairs = Pairs.of(first, second)
        return what, rate(first), rate(second), f"{pairs.first_alone} : {pairs.second_alone}, p = {pairs.p:.2g}"

    table = [
        counted("false alarms, own threshold", [alarm(workflow[i]) for i in nulls], [alarm(baseline[i]) for i in nulls]),
        counted(f"false alarms, threshold {threshold:.4g}", [alarm(workflow[i]) for i in nulls], [alarm(equal[i]) for i in nulls]),
        counted("exact name and place", [workflow[i].exact for i in known], [equal[i].exact for i in known]),
        counted("exact, own threshold", [workflow[i].exact for i in known], [baseline[i].exact for i in known]),
        counted("exact, best threshold of each case", [workflow[i].exact for i in known], [somewhere(baseline[i]) for i in known]),
        counted("known ones seen", [alarm(workflow[i]) for i in known], [alarm(equal[i]) for i in known]),
    ]
    if shares:
        a, b = np.array(shares).T
        better = f"{np.median(a - b):+.3f}, {(a > b).sum()} : {(a < b).sum()}, p = {sign_p(int((a > b).sum()), int((a < b).sum())):.2g}"
        table.append((f"gap closed G, median of {len(a)}", f"{np.median(a):.3f}", f"{np.median(b):.3f}", better))
    seconds = [np.median([case.result["seconds"] for case in found]) for found in (workflow, baseline)]
    return [*table, ("processor seconds, median", *(f"{s:.1f}" for s in seconds), f"{seconds[0] - seconds[1]:+.1f}")]


def compare(out: Path, *, cases: list[int], workflow: str = "verdicts", baselines: list[str]) -> None:
    """Prints a paired table for each baseline.

    Args:
        out: folder of answers and verdicts. cases: names; nulls among them set the thresholds.
        workflow: name of the workflow's folder of verdicts. baselines: names of those of the baselines.
    """
    for folder in baselines:
        if missing := [n for n in cases for f in (workflow, folder) if not (out / f / f"{n}.json").exists()]:
            raise ConfigError(f"There is no verdict of {workflow} or {folder} on case {missing[0]} in {out}: run it first.")
        first, second = ([scored(out, name, f) for name in cases] for f in (workflow, folder))
        sys.stdout.write(f"\n| | {workflow} | {folder} | alone, p |\n|---|---|---|---|\n")
        for row in rows(first, second):
            sys.stdout.write(f"| {' | '.join(row)} |\n")


if __name__ == "__main__":
    try:
        tyro.cli(compare)
    except HamrError as error:
        sys.exit(str(error))
