"""The whole workflow once the data are there, for any machines: find and name, write the hash, open the rest of the data, show, report.

`study` serves one machine of any kind, `conclude` several that belong together, as HAMR's legs do.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from hamr_description.errors import BagError
from hamr_dynamics import machine_kernel
from hamr_dynamics.effects import effects_file
from hamr_dynamics.machine import Machine

from .answers.answer import answer
from .answers.found import STATES, Found, find
from .answers.together import together
from .answers.version import code
from .data.drives_bag import write_drives
from .data.record import Record
from .naming.candidates import AIRBORNE
from .showing import emit
from .showing.overlay import write_overlay
from .showing.report import write_report
from .showing.show import closed, show

NAMED, HASH, VERDICT = "named.json", "verdict.sha256", "verdict.json"
EFFECTS, REPORT, OVERLAY, EXPERIMENT = "effects.yaml", "report.html", "overlay", "experiment"


@dataclass(frozen=True)
class Part:
    """A machine, what was measured of it, and what was found."""

    machine: Machine
    record: Record
    found: Found


def study(
    machine: Machine, record: Record, out: Path, *, holdout: Callable[[], Record] | None = None, command: str = "",
    report: Callable[[str], None] = lambda _: None, seed: int = 0,
) -> dict:  # fmt: skip
    """Find, name, add and show for one machine.

    Args:
        record: measured. out: folder for all that is found; what an interrupted call left there is used.
        holdout: gives the records that nothing may use before the verdict is fixed.
        command: what repeats this. report: told the stage. seed: as of `find`.

    Returns:
        The content of `verdict.json`.

    Raises:
        BagError: the record cannot be used; one sentence.
    """
    found = stored(machine, record, out, report, seed=seed)
    opened = (lambda: {machine.name: holdout()}) if holdout else None
    return conclude({machine.name: Part(machine, record, found)}, out, holdout=opened, command=command)


def stored(machine: Machine, record: Record, out: Path, report: Callable[[str], None] = lambda _: None, *, seed: int = 0) -> Found:
    """What is found about a machine, kept in `out` under a hash of data and code.

    Raises:
        BagError: the record cannot be used; one sentence.
    """
    folder, key = out / "found" / machine.name, _key(machine, record, seed)
    if found := Found.load(folder, key):
        return found
    try:
        found = find(machine, record, report, seed=seed)
    except np.linalg.LinAlgError as error:
        raise BagError(f"The fits to {machine.name} did not come to an end ({error}); record it with another excitation.") from error
    found.save(folder, key)
    return found


def kept_apart(measured: Sequence[str | Path], holdout: Sequence[str | Path]) -> None:
    """Raises BagError where something held out is measured data too: a gap that closes there would prove nothing."""
    used = {Path(path).resolve() for path in measured}
    if both := [path for path in holdout if Path(path).resolve() in used]:
        raise BagError(f"{both[0]} is both measured and held out; hold out data that the answer does not rest on.")


def conclude(
    parts: Mapping[str, Part], out: Path, *, holdout: Callable[[], Mapping[str, Record]] | None = None, command: str = "",
    refused: Mapping[str, str] | None = None, legs: bool = False,
) -> dict:  # fmt: skip
    """Fixes the answer, then opens the held-out records, shows the gap on them and writes everything.

    Args:
        legs: whether the machines are HAMR's legs, by their names: every backend takes their effects file, and a bag holds the angles.
    """
    out.mkdir(parents=True, exist_ok=True)
    founds, combinations = together({name: part.found for name, part in parts.items()})
    parts = {name: replace(part, found=founds[name]) for name, part in parts.items()}
    named = answer(founds, combinations, refused)
    if not legs:  # which walk, unlike other machines
        named["not_observable"] = [silent for silent in named["not_observable"] if silent["why"] != AIRBORNE]
    if legs and (drives := {name: x for name, part in parts.items() if len(x := part.found.arrays.get("experiment", ()))}):
        write_drives(drives, {name: parts[name].record for name in drives}, out / EXPERIMENT)
        for name in drives:
            named["experiment"][name]["bag"] = str(out / EXPERIMENT)
    text = json.dumps(named, indent=1) + "\n"
    (out / NAMED).write_text(text)
    (out / HASH).write_text(f"{hashlib.sha256(text.encode()).hexdigest()}  {NAMED}\n")
    _write_effects(list(founds.values()), out / EFFECTS, legs=legs)

    records = holdout() if holdout else {name: part.record for name, part in parts.items()}
    shown, pictures = {}, {}
    for name, part in parts.items():
        if name in records:
            shown[name], pictures[name] = show(part.machine, part.found, records[name], fresh=holdout is not None)
    whole = named | {
        "shown": _together(shown, fresh=holdout is not None), "effects_file": str(out / EFFECTS), "report": str(out / REPORT),
        "overlay": str(out / OVERLAY) if legs else "", "command": command,
    }  # fmt: skip
    if legs:
        write_overlay(pictures, out / OVERLAY)
    write_report(whole, pictures, out / REPORT)
    (out / VERDICT).write_text(json.dumps(whole, indent=1) + "\n")
    return whole


def _write_effects(founds: list[Found], path: Path, *, legs: bool) -> None:
    if legs:
        effects_file.write(emit.of_legs(founds), path)
    else:
        emit.write(founds, path)


def _together(shown: Mapping[str, dict], *, fresh: bool) -> dict:
    """The gaps of all machines, and each one's own."""
    over = {state: _mean([s["over_floor"][state] for s in shown.values()]) for state in STATES}
    horizons = {h: {state: _mean([s["horizons"][h][state] for s in shown.values()]) for state in STATES}
                for h in next(iter(shown.values()))["horizons"]}  # fmt: skip
    data = (
        "data that nothing had used before" if fresh else "the part of the measured data that was kept for this and used for nothing else"
    )
    return {"data": data, "over_floor": over, "closed": closed(over), "horizons": horizons, "machines": dict(shown)}


def _mean(x: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(x))))


def _key(machine: Machine, record: Record, seed: int) -> str:
    """Hash of the data, of the machine's traced equations with every effect, and of the workflow's code."""
    said = f"{seed} {record.channels} {record.step} {record.held} {record.hold} {record.rest} {record.drives_per_reading} {record.breaks}"
    digest = hashlib.sha256("\0".join((said, machine_kernel.source(machine), code())).encode())
    for array in (record.drives, record.readings):
        digest.update(np.ascontiguousarray(array, "<f8").tobytes())
    return digest.hexdigest()
