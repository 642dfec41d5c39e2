"""One case, blind: a case file in, an answer file out. Runs in a process of its own that knows nothing else."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

from hamr_description.errors import HamrError

from ..analyse import analyse
from ..legs import machine_of
from .cases import LEG, load


def solve(case: Path, out: Path) -> None:
    """Writes the verdict, the probabilities of everything tried, and the time it took."""
    began = time.process_time()
    try:
        analysis = analyse(machine_of("simple", LEG), load(case))
    except HamrError as error:
        out.write_text(json.dumps({"verdict": "refused", "why": str(error), "weights": [], "seconds": time.process_time() - began}))
        return
    machine = analysis.prepared.weighed.model.machine
    weights = [
        {
            "effects": [[c.effect, c.form, [machine.joints[j] for j in c.joints]] for c in w.hypothesis.effects] if w.hypothesis else None,
            "left": w.left, "probability": w.probability,
        }
        for w in analysis.weights
    ]  # fmt: skip
    state = analysis.search
    report = analysis.prepared.roles.report
    result = {
        "verdict": analysis.verdict.verdict, "weights": weights, "seconds": time.process_time() - began,
        "base": analysis.prepared.base.left, "floor": state.floor, "raw": analysis.prepared.raw, "best": state.best.left,
        "numerical": analysis.prepared.numerical, "evidence": analysis.evidence, "report": analysis.left(report),
    }  # fmt: skip
    out.write_text(json.dumps(result))


if __name__ == "__main__":
    solve(Path(sys.argv[1]), Path(sys.argv[2]))
