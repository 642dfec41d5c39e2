"""What was found about one machine, as plain data that can be stored, compared and drawn."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from zipfile import BadZipFile

import numpy as np

from hamr_dynamics.machine import Machine

from .analyse import Analysis, analyse
from .experiment import propose
from .hypothesis import Hypothesis
from .parameters import Candidate
from .record import Record
from .sensors import Sensors
from .stated import changes_of, effects_of, gap_of
from .table import fit_table
from .weigh import floor_of

#: The same machine in four states: as given, re-tuned, with the effect, and re-tuned likewise but with the effect taken out again.
STATES = ("raw", "retuned", "after", "removed")
TRIED = 12


@dataclass(frozen=True)
class Found:
    """An answer about one machine.

    Attributes:
        verdict: `verdict.Verdict` as plain values, and `added`: the effects that close the gap (those of the first answer, or a table).
        tried: [{"effects", "count", "left"}], what each name left of the gap, least first.
        simulation: substeps, mean, held and step of the simulation it rests on.
        arrays: `rows.STATE` (R,) lane parameters; `bias.STATE`, `gain.STATE` (C,), `shift.STATE` ();
            `report` (n,) readings that nothing has used; `experiment` (m, joints) drives that would decide, if ambiguous.
    """

    verdict: dict
    tried: list[dict]
    simulation: dict
    arrays: dict[str, np.ndarray]

    def sensors(self, state: str) -> Sensors:
        """The sensors' part of a state."""
        return Sensors(self.arrays[f"bias.{state}"], self.arrays[f"gain.{state}"], float(self.arrays[f"shift.{state}"]))

    def save(self, folder: Path, key: str) -> None:
        """Writes a folder under a key; whole or not at all, as the key goes last."""
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "found.json").unlink(missing_ok=True)
        np.savez_compressed(folder / "found.npz", **self.arrays)
        content = {"key": key, "verdict": self.verdict, "tried": self.tried, "simulation": self.simulation}
        (folder / "found.part").write_text(json.dumps(content))
        (folder / "found.part").rename(folder / "found.json")

    @classmethod
    def load(cls, folder: Path, key: str) -> Found | None:
        """Reads a folder back; None if there is nothing whole under this key."""
        try:
            content = json.loads((folder / "found.json").read_text())
            if content.pop("key") != key:
                return None
            with np.load(folder / "found.npz") as arrays:
                return cls(**content, arrays=dict(arrays))
        except (OSError, ValueError, KeyError, TypeError, BadZipFile):
            return None


def find(machine: Machine, record: Record, report: Callable[[str], None] = lambda _: None, *, seed: int = 0) -> Found:
    """Analyses one machine; where no name explains the gap, the force that does is found as a table.

    Args:
        seed: of the noise in a proposed experiment; nothing else is random.

    Raises:
        BagError: as of `analyse`.
    """
    analysis = analyse(machine, record, report)
    verdict, best = analysis.verdict, analysis.best
    if verdict.verdict == "unknown":
        report("table")
        best = fit_table(analysis.prepared)
        verdict = replace(verdict, gap=gap_of(analysis.prepared, best), parameters=changes_of(analysis.prepared, best.fit))
        added = effects_of(analysis.prepared, best)
    else:
        added = verdict.set[0].effects if verdict.set else ()
    arrays = _arrays(analysis, best)
    if verdict.verdict == "ambiguous":
        report("experiment")
        if decided := decides(analysis, seed=seed):
            said, arrays["experiment"] = decided
            verdict = replace(verdict, experiment=said)
    content = json.dumps(asdict(verdict) | {"added": [asdict(effect) for effect in added]})
    return Found(json.loads(content), _tried(analysis), _simulation(analysis), arrays)


def decides(analysis: Analysis, *, seed: int = 0) -> tuple[dict, np.ndarray] | None:
    """What would decide between the first two names, as in `verdict.json`, and its drives (m, joints).

    None if there is one name, or if nothing drives the machine.
    """
    model = analysis.prepared.weighed.model
    joints = model.machine.joints
    rivals = [w.hypothesis for w in analysis.weights[: len(analysis.verdict.set)] if w.hypothesis is not None][:2]
    if len(rivals) < 2 or not model.record.driven.any():
        return None
    floor = floor_of(analysis.search.floor, analysis.search.by_names().values())
    proposal = propose(analysis.prepared, *rivals, floor=floor, seed=seed)
    first, second = (in_words(h.effects, joints) for h in rivals)
    return proposal.as_dict((first, second)), proposal.drives


def _tried(analysis: Analysis) -> list[dict]:
    """What leaves least, and of each number of effects what leaves least."""
    state, joints = analysis.search, analysis.prepared.weighed.model.machine.joints
    gap = max(state.base.left - state.floor, 1e-12)
    found = sorted(state.by_names().values(), key=lambda h: h.left)
    first = {len(h.effects): h for h in reversed(found)}
    return [
        {"effects": in_words(h.effects, joints), "count": len(h.effects), "left": max(h.left - state.floor, 0.0) / gap}
        for i, h in enumerate(found) if i < TRIED or h is first[len(h.effects)]
    ]  # fmt: skip


def in_words(effects: tuple[Candidate, ...], joints: tuple[str, ...]) -> str:
    """Effects with their places."""
    return " + ".join(f"{c.effect} ({', '.join(joints[j] for j in c.joints)})" for c in effects)


def _simulation(analysis: Analysis) -> dict:
    model = analysis.prepared.weighed.model
    record = model.record
    return {
        "substeps": model.substeps, "mean": model.mean, "held": record.held, "step": record.step, "delay": model.delay, "piece": model.piece
    }  # fmt: skip


def _arrays(analysis: Analysis, best: Hypothesis) -> dict[str, np.ndarray]:
    prepared = analysis.prepared
    model, base = prepared.weighed.model, prepared.base.fit
    off = {row for c in best.effects for row, _ in c.rows(shape=False)}
    nothing = replace(Sensors.none(len(model.own)), shift=-model.delay)
    x = {
        "raw": ((), np.zeros(0)), "retuned": (base.free, base.x), "after": (best.fit.free, best.fit.x),
        "removed": (best.fit.free, np.array([0.0 if f.row in off else v for f, v in zip(best.fit.free, best.fit.x, strict=True)])),
    }  # fmt: skip
    sensors = {"raw": nothing, "retuned": base.sensors, "after": best.fit.sensors, "removed": best.fit.sensors}
    rows = {state: model.rows(*x[state])[0] for state in STATES}
    found = {"report": prepared.roles.report}
    for state in STATES:
        s = sensors[state]
        found |= {f"rows.{state}": rows[state], f"bias.{state}": s.bias, f"gain.{state}": s.gain, f"shift.{state}": np.array(s.shift)}
    return found
