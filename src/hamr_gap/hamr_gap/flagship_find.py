"""What the workflow finds between HAMR-simple and HAMR-full, whose difference `flagship` computes.

    python -m hamr_gap.flagship_find       tables of docs/flagship.md, what the workflow finds
"""

from __future__ import annotations

import sys
from itertools import combinations

import numpy as np
import tyro

from hamr_bags.excitation import excitation
from hamr_description.names import JOINTS, drive_sign
from hamr_description.numbers import value
from hamr_description.rates import SERVO_MS
from hamr_dynamics import machine_kernel

from .answers.found import in_words
from .data.record import Record
from .fitting.parameters import effect_parameters
from .flagship import EFFECTS, differences, scales
from .judging.analyse import analyse
from .legs import machine_of
from .naming.hypothesis import Hypothesis, Start, refine
from .naming.prepare import Prepared

PER_READING = 5  # servo samples for each of the encoder's
MOST = 12  # rows


def recorded(leg: str, *, seconds: float, noise: float, seed: int) -> Record:
    """A leg of HAMR-full under the paper's white noise, as encoders with white noise (a share of each channel's travel) see it."""
    full = machine_of("full", leg)
    columns = [JOINTS.index(j) for j in full.joints]
    drives = (excitation("noise", seconds=seconds, seed=seed).voltages[:, columns] - value("actuator.neutral_voltage")) * drive_sign(leg)
    truth = machine_kernel.simulate(full, drives, full.neutral(scales())[None], step=SERVO_MS, substeps=1)[0][::PER_READING]
    error = noise * np.ptp(truth, axis=0) * np.random.default_rng(seed).standard_normal(truth.shape)
    return Record(drives, truth + error, PER_READING * SERVO_MS, full.channels, held=True, drives_per_reading=PER_READING)


def from_truth(prepared: Prepared, leg: str) -> dict[tuple[str, ...], Hypothesis]:
    """Each group of the truth's effects, fitted from the truth's own numbers: what the data could tell apart, however it is searched."""
    true = {row: x for rows in differences(machine_of("simple", leg), machine_of("full", leg)).values() for row, x in rows.items()}
    found = {}
    for group in (g for size in range(1, len(EFFECTS) + 1) for g in combinations(EFFECTS, size)):
        effects = tuple(EFFECTS[name] for name in group)
        free = (*prepared.base.fit.free, *effect_parameters(effects, prepared.weighed.model.scales))
        x = np.array([true.get(f.row, 0.0) / f.scale for f in free])
        found[group] = refine(prepared.weighed, prepared.judged, Start(effects, free, x, np.inf))
    return found


def main(leg: str = "fl", seconds: float = 6.0, noise: float = 1e-3, seed: int = 3) -> None:
    """Prints what each set of names leaves, the answer, and what the truth's own groups leave."""
    machine = machine_of("simple", leg)
    analysis = analyse(machine, recorded(leg, seconds=seconds, noise=noise, seed=seed))
    state = analysis.search
    gap = state.base.left - state.floor
    say = sys.stdout.write
    say("| | left | share of the gap |\n|---|---|---|\n")
    say(f"| HAMR-simple as it is | {analysis.prepared.raw:.0f} | |\n| re-tuned | {state.base.left:.0f} | 1 |\n")
    for h in sorted(state.by_names().values(), key=lambda h: h.left)[:MOST]:
        say(f"| {in_words(h.effects, machine.joints)} | {h.left:.3g} | {(h.left - state.floor) / gap:.2g} |\n")
    say(f"| noise alone | {state.floor:.2g} | 0 |\n\n{analysis.verdict.verdict}\n")
    for w in analysis.weights[: len(analysis.verdict.set)]:
        say(f"- {w.probability:.2f} {in_words(w.hypothesis.effects, machine.joints) if w.hypothesis else 'outside the library'}\n")
    say("\n| the truth's effects, fitted from its numbers | left | share of the gap |\n|---|---|---|\n")
    for group, h in from_truth(analysis.prepared, leg).items():
        say(f"| {' + '.join(group)} | {h.left:.3g} | {(h.left - state.floor) / gap:.2g} |\n")


if __name__ == "__main__":
    tyro.cli(main)
