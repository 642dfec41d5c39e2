"""What was found as an effects file: the first answer's effects (or a table, where no name fits) and the re-tuned changes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import yaml

from hamr_dynamics.effects import effects_file

from ..answers.found import Found


def of_legs(founds: Iterable[Found]) -> effects_file.EffectsFile:
    """The file that every backend takes; parameters in SI, in the frame of each leg."""
    founds = list(founds)
    effects = [effects_file.PlacedEffect(name, form, joints, {key: x["value"] for key, x in parameters.items()})
               for found in founds for name, form, joints, parameters in _effects(found)]  # fmt: skip
    changes = [effects_file.Change(name, (joint,), x["value"]) for found in founds for name, joint, x in _changes(found)]
    return effects_file.EffectsFile(tuple(effects), tuple(changes))


def write(founds: Iterable[Found], path: Path) -> None:
    """The same shape for machines that are not HAMR's legs, in their own units."""
    founds = list(founds)
    effects = [
        {"effect": name, "form": form, "joints": list(joints),
         "parameters": {key: {"value": x["value"], "unit": x["unit"]} for key, x in parameters.items()}}
        for found in founds for name, form, joints, parameters in _effects(found)
    ]  # fmt: skip
    changes = [
        {"change": name, "joints": [joint], "value": x["value"], "unit": x["unit"]} for f in founds for name, joint, x in _changes(f)
    ]
    path.write_text(yaml.safe_dump({"effects": effects, "changes": changes}, sort_keys=False, default_flow_style=None, width=140))


def _effects(found: Found) -> Iterator[tuple[str, str, tuple[str, ...], dict[str, Mapping]]]:
    """(effect, form, joints, parameters) once for each place of its own: a joint, or the pair."""
    for effect in found.verdict["added"]:
        places = next(iter(effect["parameters"].values()))
        for place in places:
            joints = (place,) if place in effect["joints"] else tuple(effect["joints"])
            yield effect["effect"], effect["form"], joints, {key: at[place] for key, at in effect["parameters"].items()}


def _changes(found: Found) -> Iterator[tuple[str, str, Mapping]]:
    if found.verdict["verdict"] != "no_significant_gap":
        for name, joints in found.verdict["parameters"].items():
            for joint, estimate in joints.items():
                yield name, joint, estimate
