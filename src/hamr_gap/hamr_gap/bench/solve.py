"""One case, blind: case files of one machine in, an answer file out. Runs in a process of its own that knows nothing else.

python -m hamr_gap.bench.solve ANSWER CASE [CASE ...]
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np

from hamr_description.errors import HamrError

from ..answers.found import decides
from ..data.record import joined
from ..fitting.threads import use
from ..judging.analyse import analyse
from ..judging.weigh import Weight
from ..legs import machine_of
from ..walking.analyse import analyse as analyse_walk
from ..walking.bags import read
from .cases import LEG, load


def solve(out: Path, *cases: Path) -> None:
    """Writes the verdict, the probabilities of everything tried, and the time it took; and beside it the drives that would decide.

    A folder is a bag of a walk, a file one of a leg.
    """
    began = time.process_time()
    try:
        if cases[0].is_dir():
            out.write_text(json.dumps(_walk(cases) | {"seconds": time.process_time() - began}))
            return
        analysis = analyse(machine_of("simple", LEG), joined([load(case) for case in cases]))
    except HamrError as error:
        out.write_text(json.dumps({"verdict": "refused", "why": str(error), "weights": [], "seconds": time.process_time() - began}))
        return
    joints = analysis.prepared.weighed.model.machine.joints
    weights = _weights(analysis.weights, lambda c: [joints[j] for j in c.joints])
    state = analysis.search
    report = analysis.prepared.roles.report
    seconds = time.process_time() - began
    experiment = None
    if analysis.verdict.verdict == "ambiguous" and (decided := decides(analysis)):
        experiment, drives = decided
        if len(drives):
            np.savez(out.with_suffix(".npz"), drives=drives)
    result = {
        "verdict": analysis.verdict.verdict, "weights": weights, "set": [asdict(answer) for answer in analysis.verdict.set],
        "experiment": experiment, "seconds": seconds,
        "base": analysis.prepared.base.left, "floor": state.floor, "raw": analysis.prepared.raw, "best": state.best.left,
        "numerical": analysis.prepared.weighed.numerical, "evidence": analysis.evidence, "report": analysis.left(report),
    }  # fmt: skip
    out.write_text(json.dumps(result))


def _walk(cases: Sequence[Path]) -> dict:
    found = analyse_walk("simple", read(cases))
    prepared = found.search.prepared
    return {
        "verdict": found.word, "weights": _weights(found.weights, lambda c: list(c.joints)), "set": [], "experiment": None,
        "base": prepared.base.left, "floor": found.search.floor, "raw": prepared.raw.left, "best": found.search.best.left,
        "numerical": prepared.numerical, "evidence": found.evidence, "report": found.left("report"),
    }  # fmt: skip


def _weights(weights: Sequence[Weight], joints: Callable) -> list[dict]:
    """Names with their probabilities, most probable first; `joints` gives a candidate's."""
    return [
        {
            "effects": [[c.effect, c.form, joints(c)] for c in w.hypothesis.effects] if w.hypothesis else None,
            "left": w.left, "probability": w.probability,
        }
        for w in weights
    ]  # fmt: skip


if __name__ == "__main__":
    use(1)  # as many cases as cores are solved beside each other
    solve(*map(Path, sys.argv[1:]))
