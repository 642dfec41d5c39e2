"""What was found about one machine, as plain data that can be stored, compared and drawn."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from zipfile import BadZipFile

import numpy as np

from hamr_dynamics.machine import Machine

from ..data.record import Record
from ..experiments.experiment import propose
from ..fitting.parameters import Candidate
from ..fitting.sensors import Sensors
from ..judging.analyse import Analysis, analyse, answer_of
from ..judging.stated import stated
from ..judging.table import fit_table
from ..judging.weigh import Weight
from ..naming.hypothesis import Hypothesis, settled
from ..naming.prepare import Prepared

#: The same machine in four states: as given, re-tuned, with the effect, and re-tuned likewise but with the effect taken out again.
STATES = ("raw", "retuned", "after", "removed")
TRIED = 12


@dataclass(frozen=True)
class Found:
    """An answer about one machine.

    Attributes:
        verdict: `verdict.Verdict` as plain values, and `added`: the effects that close the gap (those of the first answer, or a table).
        tried: [{"effects", "count", "left"}], what each name left of the gap, least first.
        simulation: substeps, mean, held and step of the simulation it rests on, and whether pieces began where it leaves least.
        arrays: `rows.STATE` (R,) lane parameters; `bias.STATE`, `gain.STATE` (C,), `shift.STATE` (); the same of the k-th answer,
            where it has effects, with `.k` behind;
            `report` (n,) readings that nothing has used; `experiment` (m, joints) drives that would decide, if ambiguous.
        answers: those of the verdict's set, and behind them less probable ones, for which other machines that are built alike may
            speak; each that is not `unknown` with its own `parameters` and `gap`.
    """

    verdict: dict
    tried: list[dict]
    simulation: dict
    arrays: dict[str, np.ndarray]
    answers: list[dict]

    def led_by(self, k: int) -> Found:
        """The same with the k-th answer, which is not `unknown`, as the first of the set."""
        if k == 0:
            return self
        own = self.answers[k]
        plain = {key: x for key, x in own.items() if key not in ("parameters", "gap")}
        others = [x for i, x in enumerate(self.verdict["set"]) if i != k]
        verdict = self.verdict | {"verdict": "ambiguous", "set": [plain, *others], "added": own["effects"]}
        verdict |= {key: own[key] for key in ("parameters", "gap")}
        arrays = {name: self.arrays.get(f"{name}.{k}", array) for name, array in self.arrays.items()}
        return replace(self, verdict=verdict, arrays=arrays)

    def sensors(self, state: str) -> Sensors:
        """The sensors' part of a state."""
        return Sensors(self.arrays[f"bias.{state}"], self.arrays[f"gain.{state}"], float(self.arrays[f"shift.{state}"]))

    def save(self, folder: Path, key: str) -> None:
        """Writes a folder under a key; whole or not at all, as the key goes last."""
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "found.json").unlink(missing_ok=True)
        np.savez_compressed(folder / "found.npz", **self.arrays)
        content = {"key": key} | {name: getattr(self, name) for name in ("verdict", "tried", "simulation", "answers")}
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
    """Analyses one machine; where no name explains the gap, the force that does is found as a table, if one helps.

    Args:
        seed: of the noise in a proposed experiment; nothing else is random.

    Raises:
        BagError: as of `analyse`.
    """
    analysis = analyse(machine, record, report)
    prepared, verdict, best = analysis.prepared, analysis.verdict, analysis.best
    first = analysis.said[best]
    if verdict.verdict == "unknown":
        report("table")
        known = analysis.part or prepared.base
        best = min(known, fit_table(prepared, known), key=lambda h: h.left)
        first = stated(prepared, best)
        verdict = replace(verdict, gap=first.gap, parameters=first.parameters)
    arrays = {"report": prepared.roles.report} | _states(prepared, best)
    weights = [*analysis.chosen, *(_settled(analysis, w) for w in analysis.beyond)]
    for k, weight in enumerate(weights):
        if weight.hypothesis:
            arrays |= {f"{name}.{k}": array for name, array in _states(prepared, weight.hypothesis).items()}
    if verdict.verdict == "ambiguous":
        report("experiment")
        if decided := decides(analysis, seed=seed):
            sentence, arrays["experiment"] = decided
            verdict = replace(verdict, experiment=sentence)
    content = asdict(verdict) | {"added": [asdict(effect) for effect in first.effects]}
    content, answers = json.loads(json.dumps([content, [_answer(analysis, weight) for weight in weights]]))
    return Found(content, _tried(analysis), _simulation(analysis), arrays, answers)


def _settled(analysis: Analysis, weight: Weight) -> Weight:
    h = weight.hypothesis
    return weight if h is None else replace(weight, hypothesis=settled(analysis.prepared.weighed, analysis.prepared.judged, h))


def _answer(analysis: Analysis, weight: Weight) -> dict:
    """An answer as plain values, with its own parameters and gap where the library has all of it."""
    h = weight.hypothesis
    if h is None:
        return asdict(answer_of(analysis.search, weight, analysis.said.get(analysis.part)))
    said = analysis.said.get(h) or stated(analysis.prepared, h)
    own = asdict(said)
    return asdict(answer_of(analysis.search, weight, said)) | {key: own[key] for key in ("parameters", "gap")}


def decides(analysis: Analysis, *, seed: int = 0) -> tuple[dict, np.ndarray] | None:
    """What would decide between the names of the set, as in `verdict.json`, and its drives (m, joints).

    None if there is one name, or if nothing drives the machine.
    """
    model, state = analysis.prepared.weighed.model, analysis.search
    rivals = [w.hypothesis for w in analysis.weights[: len(analysis.verdict.set)] if w.hypothesis is not None]
    if len(rivals) < 2 or not model.record.driven.any():
        return None
    proposal = propose(analysis.prepared, [state.forms_of(h) for h in rivals], noise=state.floor, seed=seed)
    return proposal.as_dict([in_words(h.effects, model.machine.joints) for h in rivals]), proposal.drives


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
        "substeps": model.substeps, "mean": model.mean, "held": record.held, "step": record.step, "delay": model.delay,
        "piece": model.piece, "settled": model.begins,
    }  # fmt: skip


def _states(prepared: Prepared, best: Hypothesis) -> dict[str, np.ndarray]:
    """Lane parameters and sensors of all states, as in `Found.arrays`."""
    model, base = prepared.weighed.model, prepared.base.fit
    off = {row for c in best.effects for row, _ in c.rows(shape=False)}
    nothing = replace(Sensors.none(len(model.own)), shift=-model.delay)
    x = {
        "raw": ((), np.zeros(0)), "retuned": (base.free, base.x), "after": (best.fit.free, best.fit.x),
        "removed": (best.fit.free, np.array([0.0 if f.row in off else v for f, v in zip(best.fit.free, best.fit.x, strict=True)])),
    }  # fmt: skip
    sensors = {"raw": nothing, "retuned": base.sensors, "after": best.fit.sensors, "removed": best.fit.sensors}
    rows = {state: model.rows(*x[state])[0][: len(model.neutral)] for state in STATES}
    return {
        f"{name}.{state}": value for state, s in sensors.items()
        for name, value in (("rows", rows[state]), ("bias", s.bias), ("gain", s.gain), ("shift", np.array(s.shift)))
    }  # fmt: skip
