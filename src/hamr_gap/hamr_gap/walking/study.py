"""The walking study: find, name, add and show for a robot on the ground, in the files and the shape of the legs' study."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from hamr_dynamics.effects import effects_file

from ..answers.answer import answer
from ..answers.found import STATES, Found
from ..answers.together import together
from ..answers.version import code
from ..showing.report import write_report
from ..showing.show import closed
from ..study import EFFECTS, HASH, NAMED, REPORT, VERDICT
from .bags import read
from .found import ROBOT, by_channel, find, model_of, robot_of, seen_of
from .found import effects_file as found_effects
from .left import trimmed
from .replay import Replay
from .segments import CHANGES, Segments, segments
from .starts import start
from .strides import strides
from .walk import Walk

SHOWN_MS = 50.0
HORIZONS_MS = (8.0, 20.0, 50.0)
#: A note that does not hold on the ground, where weight fixes the scale.
DROPPED = "Drive and angle fix"


def run(measured: Sequence[str | Path], out: Path, backend: str, holdout: Sequence[str | Path] = (), command: str = "",
        report: Callable[[str], None] = lambda _: None) -> dict:  # fmt: skip
    """The study for bags from the ground.

    Args:
        measured: bags with drive voltages, hip angles and the chassis's pose. out: folder for all that is found.
        backend: the model. holdout: bags that are opened only after the answer is fixed. command: what repeats this. report: told stages.

    Returns:
        The content of `verdict.json`.

    Raises:
        BagError: a bag cannot be used; one sentence.
    """
    opened = (lambda: read(holdout)) if holdout else None
    return study(backend, read(measured), out, holdout=opened, command=command, report=report)


def study(backend: str, walk: Walk, out: Path, *, holdout: Callable[[], Walk] | None = None, command: str = "",
          report: Callable[[str], None] = lambda _: None) -> dict:  # fmt: skip
    """The same for what was measured already; `holdout` is called after the answer's hash is written."""
    found = _stored(backend, walk, out, report)
    named = answer(*together({ROBOT: found}))
    named["notes"] = [note for note in named["notes"] if not note.startswith(DROPPED)]
    text = json.dumps(named, indent=1) + "\n"
    (out / NAMED).write_text(text)
    (out / HASH).write_text(f"{hashlib.sha256(text.encode()).hexdigest()}  {NAMED}\n")
    effects_file.write(found_effects(found), out / EFFECTS)
    report("show")
    shown = show(found, holdout() if holdout else walk, fresh=holdout is not None)
    whole = named | {"shown": shown, "effects_file": str(out / EFFECTS), "report": str(out / REPORT), "overlay": "", "command": command}
    write_report(whole, {}, out / REPORT)
    (out / VERDICT).write_text(json.dumps(whole, indent=1) + "\n")
    return whole


def show(found: Found, walk: Walk, *, fresh: bool) -> dict:
    """Gaps of all states on segments that nothing has used, at several horizons, and strides.

    Args:
        fresh: whether nothing has seen the walk; if not, only the turns of the report role count.
    """
    robot, whole = robot_of(found), segments(seen_of(found, walk), length_ms=SHOWN_MS, every_ms=SHOWN_MS)
    replay = Replay.of(robot, whole if fresh else _kept(whole, np.array(found.simulation["report"])))
    left, over = {}, {}
    for state in STATES:
        left[state] = start(replay, model_of(found, state)).residual[:, :-CHANGES]
        over[state] = float(np.sqrt(trimmed(left[state])[0]))
    observed = replay.observed
    horizons = {}
    for ms in HORIZONS_MS:
        samples = round(ms / walk.step)
        horizons[f"{ms / 1e3:g} s"] = {s: _over(replay, x, samples) for s, x in left.items()}
    each = {state: by_channel(observed, x) for state, x in left.items()}
    angles = np.sqrt(observed.mean) * observed.noise.angle
    noise = [*angles.tolist(), 1e-3 * float(observed.noise.position.mean()), float(observed.noise.turn.mean())]
    channels = {c: {"unit": "m" if c.endswith("position") else "rad", "noise": n} | {s: each[s][c] for s in STATES}
                for c, n in zip(each["raw"], noise, strict=True)}  # fmt: skip
    own = {"readings": left["raw"].size, "over_floor": over, "closed": closed(over), "channels": channels, "horizons": horizons}
    data = "walks that nothing had used before" if fresh else "the part of the walk that was kept for this and used for nothing else"
    models = {state: model_of(found, state) for state in ("raw", "after")}
    return {"data": data, "over_floor": over, "closed": own["closed"], "horizons": horizons, "machines": {ROBOT: own},
            "strides": strides(walk, robot, models)}  # fmt: skip


def _over(replay: Replay, residual: np.ndarray, samples: int) -> float:
    """Rms in noise of the readings up to a horizon, the worst segments left out."""
    observed = replay.observed
    angles, poses = observed.apart(residual)
    near = angles[:, : samples // observed.mean], poses[:, : int((observed.at[0] <= samples).sum())]
    return float(np.sqrt(trimmed(np.concatenate([x.reshape(len(x), -1) for x in near], 1))[0]))


def _kept(whole: Segments, first: np.ndarray) -> Segments:
    """Segments within the turns that were kept: each begins and ends beside one that did."""
    away = np.abs(whole.first[:, None] + np.array([0, whole.samples])[:, None, None] - first).min(-1).max(0)
    return whole.some(np.flatnonzero(away <= whole.samples))


def _stored(backend: str, walk: Walk, out: Path, report: Callable[[str], None]) -> Found:
    """What was found, kept under a hash of data and code."""
    out.mkdir(parents=True, exist_ok=True)
    digest = hashlib.sha256(f"{backend} {walk.step} {walk.breaks} {code()}".encode())
    for array in (walk.voltages, walk.angles, walk.seen, walk.position, walk.quaternion):
        digest.update(np.ascontiguousarray(array, "<f8").tobytes())
    folder, key = out / "found" / ROBOT, digest.hexdigest()
    if found := Found.load(folder, key):
        return found
    found = find(backend, walk, report)
    found.save(folder, key)
    return found
