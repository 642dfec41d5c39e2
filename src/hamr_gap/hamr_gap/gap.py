"""`hamr gap` for bags of HAMR. Hung up, every leg is a machine of its own, with one answer for all; on the ground the robot is one."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from hamr_description.errors import BagError, HamrError
from hamr_description.names import LEGS
from hamr_dynamics.plant import plant

from .answers.found import Found
from .data.measured import Samples, environment, read
from .data.record import Record, joined
from .legs import machine_of, record_of
from .progress import side_by_side
from .study import Part, conclude, kept_apart, stored

STILL = 0.05  # of its usual size, that a drive has at first where the machine begins at rest
FIRST = 5  # samples that tell


@dataclass(frozen=True)
class Refused:
    """Why nothing can be said about a leg."""

    sentence: str


def run(measured: Sequence[Path], out: Path, *, backend: str, holdout: Sequence[Path] = (), seed: int = 0) -> dict:
    """Find, name, add and show.

    Args:
        measured: bags of suspended legs, or of walks, of any recorder. out: folder for all that is found.
        backend: the model, a name of `hamr_dynamics.plant.HOMES`. holdout: bags that are opened only after the answer is fixed.
        seed: as of `found.find`.

    Returns:
        The content of `verdict.json`.

    Raises:
        BagError: no bag, or no leg, can be used; the sentences say why. Single ones that cannot are left out, and said to be.
    """
    plant(backend)  # a wrong name is said before a long wait
    if lost := [bag for bag in holdout if not Path(bag).exists()]:
        raise BagError(f"There is no bag at {lost[0]}; give hold-out bags that exist.")
    kept_apart(measured, holdout)
    if any(_on_ground(bag) for bag in measured):
        from .walking.study import run as on_ground  # whose kernels of the whole robot nothing else needs

        command = _command(measured, holdout, backend, out, seed)
        return side_by_side({"robot": partial(on_ground, measured, out, backend, holdout, command)})["robot"]
    samples, refused = _opened(measured)
    records = _records(samples, refused)
    jobs = {leg: partial(_leg, backend, leg, record, out, seed) for leg, record in records.items()}
    found = side_by_side(jobs)
    refused |= {leg: result.sentence for leg, result in found.items() if isinstance(result, Refused)}
    parts = {leg: Part(machine_of(backend, leg), records[leg], result) for leg, result in found.items() if isinstance(result, Found)}
    if not parts:
        raise BagError(" ".join(f"{name}: {why}" for name, why in refused.items()))
    opened = partial(_held_out, holdout, {leg: part.record.channels for leg, part in parts.items()}) if holdout else None
    return conclude(parts, out, holdout=opened, command=_command(measured, holdout, backend, out, seed), refused=refused, legs=True)


def _on_ground(bag: Path) -> bool:
    try:
        return environment(bag) == "ground"
    except BagError:
        return False  # said where it is read


def _opened(bags: Sequence[Path]) -> tuple[list[Samples], dict[str, str]]:
    samples, refused = [], {}
    for bag in bags:
        try:
            samples.append(read(bag))
        except BagError as error:
            refused[str(bag)] = str(error)
    if not samples:
        raise BagError(" ".join(refused.values()))
    return samples, refused


def _records(samples: Sequence[Samples], refused: dict[str, str]) -> dict[str, Record]:
    """Leg -> all that was measured of it, bags one after the other."""
    found = {}
    for leg in LEGS:
        parts = [_record(s, leg) for s in samples if leg in s.legs]
        if not parts:
            continue
        common = tuple(c for c in parts[0].channels if all(c in part.channels for part in parts))
        try:
            found[leg] = joined([_only(part, common) for part in parts])
        except HamrError as error:
            refused[leg] = str(error)
    return found


def _record(samples: Samples, leg: str) -> Record:
    record = record_of(samples, leg, samples.joints)
    usual = np.sqrt(np.mean((record.drives - record.drives.mean(0)) ** 2, axis=0))
    return replace(record, rest=bool((np.abs(record.drives[:FIRST]) <= STILL * usual).all()))


def _only(record: Record, channels: tuple[str, ...]) -> Record:
    """A record of some of its channels."""
    if missing := [c for c in channels if c not in record.channels]:
        raise BagError(f"the hold-out bags lack the sensor {missing[0]}; hold out bags with the channels of the measured ones.")
    return replace(record, readings=record.readings[:, [record.channels.index(c) for c in channels]], channels=channels)


def _leg(backend: str, leg: str, record: Record, out: Path, seed: int, report: Callable[[str], None]) -> Found | Refused:
    try:
        return stored(machine_of(backend, leg), record, out, report, seed=seed)
    except HamrError as error:
        return Refused(str(error))


def _held_out(bags: Sequence[Path], channels: Mapping[str, tuple[str, ...]]) -> dict[str, Record]:
    samples = [read(bag) for bag in bags]
    parts = {leg: [_only(_record(s, leg), own) for s in samples if leg in s.legs] for leg, own in channels.items()}
    if not any(parts.values()):
        raise BagError("The hold-out bags hold none of the legs that were measured; hold out a run of the same legs.")
    return {leg: joined(records) for leg, records in parts.items() if records}


def _command(measured: Sequence[Path], holdout: Sequence[Path], backend: str, out: Path, seed: int) -> str:
    words = ["hamr", "gap", "--measured", *map(str, measured), *(["--holdout", *map(str, holdout)] if holdout else [])]
    return shlex.join([*words, "--backend", backend, "--out", str(out), "--seed", str(seed)])
