"""Whether any drive signal tells an ambiguous answer's names apart, as the hidden machine itself would show it without noise.

For the scorer, who has the answers: what a verdict says of experiments is held against this. Every signal that a verdict may ask for is
played to the hidden machine, and every name of the answer is refitted to both runs: python -m hamr_gap.bench.decidable OUT VERDICTS NUMBER
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from hidden_gap.case import JOINTS, LEG, Case

from ..experiments.apart import Follower, after, shapes, within
from ..experiments.experiment import LENGTHS_S
from ..fitting.threads import use
from ..fitting.weighed import Weighed
from ..legs import record_of
from ..naming.hypothesis import Hypothesis
from .cases import case_of, samples_of
from .ideal import fits_of, noise_free, truth_of
from .score import kept_in, scored
from .second import played

PLAYED_S = 8.0  # of each signal; a longer run shows as much in each second
WAY = "decidable"  # of what is kept beside verdicts
FORMS = 3  # of each name that are refitted


def decidable(case: Case, rivals: Sequence[frozenset]) -> dict[str, float]:
    """Signal -> by how much further than the right names the nearest others would be from the truth in the longest run, as d'.

    Args:
        rivals: names and places, (family, joints), of an answer, but for the right ones.
    """
    prepared, state, noise = noise_free(case)
    weighed = prepared.weighed
    model, first = weighed.model, weighed.model.record
    prepared = replace(prepared, weighed=replace(weighed, sigma=noise / np.sqrt(model.mean)))
    own, *others = (sorted(fits_of(prepared, state, names), key=lambda h: h.left)[:FORMS] for names in (truth_of(case), *rivals))
    found = {}
    for name, largest in shapes(model, PLAYED_S).items():
        drives = within(model, largest, *(forms[0] for forms in (own, *others)))
        truth, volts = played(case, first, drives)
        both = after(prepared, record_of(samples_of(case, truth, truth, volts), LEG, JOINTS))
        right, *wrong = (min(_squares(both, len(model.target), h) for h in forms) for forms in (own, *others))
        found[name] = float(np.sqrt(max(min(wrong) - right, 0.0)))
    return found


def _squares(both: Weighed, own: int, h: Hypothesis) -> float:
    """Squares that a refit leaves, in units of the noise, were the second run the longest there is."""
    left = Follower(both, own, h).refitted(both.model.target)
    record, run = both.chosen[:own].sum(), both.chosen[own:].sum()
    return left.record * record + left.run * run * LENGTHS_S[-1] / PLAYED_S


def main(out: Path, verdicts: str, name: int) -> None:
    """Writes it for one case."""
    said = scored(out, name, verdicts)
    rivals = [
        frozenset((family, tuple(JOINTS.index(j) for j in joints)) for family, joints in names)
        for names in said.answers if names and names != said.truth
    ]  # fmt: skip
    folder = kept_in(out, verdicts, WAY)
    folder.mkdir(exist_ok=True)
    (folder / f"{name}.json").write_text(json.dumps(decidable(case_of(out / "answers" / f"{name}.json"), rivals)))


if __name__ == "__main__":
    use(1)
    main(Path(sys.argv[1]), sys.argv[2], int(sys.argv[3]))
