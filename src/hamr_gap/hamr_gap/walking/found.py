"""From a search on the ground to a verdict as plain data, in the shape that the legs' study has."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, replace

import numpy as np

from hamr_description.names import JOINTS
from hamr_dynamics.effects.bank import CHANGES as CHANGE_KINDS
from hamr_dynamics.effects.effects_file import EffectsFile, parse
from hamr_dynamics.effects.library import library
from hamr_dynamics.effects.si import si_factor, si_unit

from ..answers.found import STATES, Found
from ..fitting.parameters import Free
from ..judging.colour import correlation_time
from ..judging.interval import NORMAL_95, within
from ..judging.verdict import Answer, Estimate, Gap, NamedEffect, Verdict
from ..naming.hypothesis import Hypothesis
from .analyse import analyse
from .candidates import missing
from .fit import Fit
from .observe import Observed
from .robot import Numerics, Robot
from .segments import CHANGES
from .setting import Setting, setting
from .starts import start
from .state import Search
from .walk import Noise, Walk

ROBOT = "robot"
BASE_CHANNELS = ("chassis_position", "chassis_turn")
NOTES = (
    "Every segment starts anew, from a state that is fitted with the model: what differs less than a start may be off shows as nothing.",
    "Clocks, and the zeros of the sensors and of the ground's height, were fitted along with the re-tune.",
)
WORSE = 1.2  # times the sensors' noise that readings count as, from which on it is said


def find(backend: str, walk: Walk, report: Callable[[str], None] = lambda _: None) -> Found:
    """Find and name for the whole robot on the ground.

    Raises:
        BagError: the walk cannot be used; one sentence.
    """
    found = analyse(backend, walk, report)
    state, best = found.search, found.best
    answers = tuple(
        Answer(_effects(state, w.hypothesis), w.probability, w.left, _forms(state, w.hypothesis)) if w.hypothesis
        else Answer((), w.probability, w.left, unknown=True) for w in found.chosen
    )  # fmt: skip
    observed = state.prepared.parts["select"].observed
    silent = {name: why for name in library() if (why := missing(name)) and why != "it is no name"}
    verdict = Verdict(
        machine=ROBOT, joints=JOINTS, verdict=found.word, set=answers, parameters=_changes(state, best), gap=_gap(state, best),
        where=tuple(_where(observed, _residual(state, state.base.fit.model))), not_observable=silent, detectable={}, experiment=None,
        notes=notes(state.prepared.worse),
    )  # fmt: skip
    added = answers[0].effects if found.word in ("named", "ambiguous") else ()
    content = json.loads(json.dumps(asdict(verdict) | {"added": [asdict(e) for e in added]}))
    return Found(content, _tried(state), _simulation(state, best), {}, content["set"])


def seen_of(found: Found, walk: Walk) -> Walk:
    """A walk whose readings count as no better than those of the one that was studied."""
    return replace(walk, known=Noise(*map(np.array, found.simulation["noise"])))


def model_of(found: Found, state: str) -> Setting:
    """The model of one of `found.STATES`."""
    own = found.simulation["models"][state]
    return Setting(parse(own["effects"]), own["shift"], tuple(own["zeros"]), tuple(own["gains"]))


def robot_of(found: Found) -> Robot:
    """A robot as finely simulated as the search did it."""
    return Robot(found.simulation["backend"], Numerics(**found.simulation["numerics"]))


def notes(worse: float) -> tuple[str, ...]:
    """What is said of any walk, and of one whose readings count as `worse` times as noisy as its sensors are."""
    if worse < WORSE:
        return NOTES
    return *NOTES, f"Readings count as {worse:.1f} times as noisy as they are, for the starts of segments cannot be told better."


def _simulation(state: Search, best: Hypothesis) -> dict:
    without = setting(best.fit.free, best.fit.x)
    models = dict(zip(STATES, (Setting(), state.base.fit.model, best.fit.model, without), strict=True))
    robot, noise = state.prepared.parts["fit"].robot, state.prepared.parts["fit"].segments.walk.noise
    plain = {
        name: {"effects": m.effects.as_dict(), "shift": m.shift, "zeros": list(m.zeros), "gains": list(m.gains)}
        for name, m in models.items()
    }
    return {"backend": robot.backend, "numerics": asdict(robot.numerics), "models": plain,
            "noise": [x.tolist() for x in (noise.angle, noise.position, noise.turn)],
            "report": state.prepared.parts["report"].segments.first.tolist()}  # fmt: skip


def _intervals(state: Search, found: Fit) -> np.ndarray:
    """(P, 2) 95 % in scales: what the model leaves counts as noise, with its colour, and so does where a fit happens to end."""
    left = found.residual[:, :-CHANGES]
    angles = left[:, : state.prepared.parts["fit"].observed.angle_readings].reshape(-1, len(JOINTS))
    inflation = correlation_time(angles) * (1.0 + found.away**2)
    scale = 1.0 / np.sqrt(np.diag(found.hessian))
    inverse = np.linalg.pinv(found.hessian * scale[:, None] * scale, hermitian=True) * scale[:, None] * scale
    half = NORMAL_95 * np.sqrt(np.minimum(np.diag(inverse) * inflation, np.square([f.sd for f in found.free])))
    return within(found.free, found.x, half)


def _estimates(state: Search, found: Fit) -> dict[str, tuple[Free, float, float, float]]:
    bounds = _intervals(state, found)
    return {f.row: (f, float(x), *map(float, b)) for f, x, b in zip(found.free, found.x, bounds, strict=True)}


def _effects(state: Search, h: Hypothesis) -> tuple[NamedEffect, ...]:
    known, found = _estimates(state, h.fit), []
    for c in h.effects:
        parameters = {}
        for p in c.law.parameters:
            f, *three = known[c.row(p)]
            factor = f.scale * si_factor(p.dimension)
            parameters[p.name] = {c.place: Estimate(*(factor * x for x in three), si_unit(p.dimension))}
        found.append(NamedEffect(c.effect, c.form, c.joints, parameters))
    return tuple(found)


def _changes(state: Search, h: Hypothesis) -> dict[str, dict[str, Estimate]]:
    found: dict[str, dict[str, Estimate]] = {}
    for row, (f, *three) in _estimates(state, h.fit).items():
        if row.startswith("change."):
            _, name, joint = row.split(".")
            factor = f.scale * si_factor(CHANGE_KINDS[name])
            found.setdefault(name, {})[joint] = Estimate(*(factor * x for x in three), si_unit(CHANGE_KINDS[name]))
    return found


def _residual(state: Search, model: Setting) -> np.ndarray:
    """(s, readings) of the judged segments."""
    return start(state.prepared.parts["select"], model, state.prepared.starts["select"].change).residual[:, :-CHANGES]


def _gap(state: Search, best: Hypothesis) -> Gap:
    models = {"raw": Setting(), "retuned": state.base.fit.model, "after": best.fit.model}
    left = {name: _residual(state, m) for name, m in models.items()}
    observed = state.prepared.parts["select"].observed
    totals = {name: float(np.sqrt(h.left)) for name, h in (("raw", state.prepared.raw), ("retuned", state.base), ("after", best))}
    each = {name: by_channel(observed, x) for name, x in left.items()}
    channels = {c: {n: each[n][c] for n in models} for c in each["raw"]}
    return Gap(**totals, floor=float(np.hypot(1.0, state.prepared.numerical)), per_channel=channels)


def by_channel(observed: Observed, residual: np.ndarray, until: int | None = None) -> dict[str, float]:
    """Rms of each channel, SI: angles rad, and m and rad of the chassis; with `until`, within so many samples after the start only."""
    noise, there = observed.noise, observed.there
    angles, poses = observed.apart(residual)
    angles, poses = angles * noise.angle, poses * np.concatenate([1e-3 * noise.position, noise.turn])
    if until is not None:
        angles, there = angles[:, : until // observed.mean], there & (observed.at <= until)
    found = dict(zip(JOINTS, np.sqrt(np.mean(angles**2, (0, 1))).tolist(), strict=True))
    for name, part in zip(BASE_CHANNELS, (slice(0, 3), slice(3, 6)), strict=True):
        found[name] = float(np.sqrt(np.mean(poses[there][:, part] ** 2)))
    return found


def _where(observed: Observed, residual: np.ndarray) -> list[str]:
    """One sentence for each channel that is off, and how the gap grows."""
    angles, poses = observed.apart(residual)
    g, poses = angles.shape[1], poses[observed.there]
    over = np.sqrt(np.mean(angles**2, (0, 1)) / observed.mean)
    said = [f"{joint}: residual {x:.1f} times the noise" for joint, x in zip(JOINTS, over, strict=True)]
    for name, part in zip(BASE_CHANNELS, (slice(0, 3), slice(3, 6)), strict=True):
        said.append(f"{name}: residual {np.sqrt(np.mean(poses[:, part] ** 2)):.1f} times the noise")
    early, late = (np.sqrt(np.mean(part**2)) for part in (angles[:, : g // 4], angles[:, -g // 4 :]))
    return [*said, f"angles: {late / early:.1f} times as far off in the last quarter of a segment as in the first"]


def _forms(state: Search, answer: Hypothesis) -> dict[str, float]:
    gap = max(state.base.left - state.floor, 1e-12)
    same = sorted((h for h in state.tried if h.names == answer.names), key=lambda h: -h.left)
    return {" + ".join(c.form for c in h.effects): max(h.left - state.floor, 0.0) / gap for h in same}


def _tried(state: Search) -> list[dict]:
    gap = max(state.base.left - state.floor, 1e-12)
    rows = [
        {"effects": " + ".join(f"{c.effect} ({c.place})" for c in h.effects), "count": len(h.effects),
         "left": max(h.left - state.floor, 0.0) / gap}
        for h in state.by_names().values()
    ]  # fmt: skip
    return sorted(rows, key=lambda row: row["left"])


def effects_file(found: Found) -> EffectsFile:
    """The model that was found, for `--effects`."""
    return model_of(found, "after").effects if found.verdict["verdict"] != "no_significant_gap" else EffectsFile()
