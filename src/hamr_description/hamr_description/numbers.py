"""Access to numbers.yaml: `number("actuator.damping")` with unit, bounds and source, `value(...)` for the bare value."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib import resources

import numpy as np
import yaml

from .errors import ConfigError


@dataclass(frozen=True, slots=True)
class Number:
    """A physical number as published or chosen.

    Attributes:
        path: where it stands in numbers.yaml, dotted.
        value: float, or read-only array.
        unit: unit in the inside system (g, mm, ms, N, V, rad).
        bounds: lowest and highest plausible value (of every element).
        source: key of `sources()`.
    """

    path: str
    value: float | np.ndarray
    unit: str
    bounds: tuple[float, float]
    source: str


@cache
def _tree() -> dict:
    text = resources.files(__package__).joinpath("numbers.yaml").read_text()
    return yaml.load(text, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))


def sources() -> dict[str, str]:
    """Short name -> full citation."""
    return _tree()["sources"]


@cache
def number(path: str) -> Number:
    """The number at a dotted path; ConfigError names the level at which the path ends."""
    node = _tree()
    for key in path.split("."):
        if not isinstance(node, dict) or key not in node:
            known = ", ".join(node) if isinstance(node, dict) else "nothing below it"
            raise ConfigError(f"numbers.yaml has no '{path}': '{key}' is unknown here (known: {known}).")
        node = node[key]
    if not isinstance(node, dict) or "value" not in node:
        raise ConfigError(f"numbers.yaml: '{path}' is a group, not a number.")
    value = np.asarray(node["value"], float)
    if value.ndim:
        value.setflags(write=False)
    return Number(path, value if value.ndim else float(value), node["unit"], tuple(node["bounds"]), node["source"])


def value(path: str) -> float | np.ndarray:
    """Value alone: float, or read-only array."""
    return number(path).value


def all_numbers() -> list[Number]:
    """Every number, in file order."""

    def walk(node: dict, path: str):
        for key, child in node.items():
            where = f"{path}.{key}" if path else key
            if "value" in child:
                yield number(where)
            else:
                yield from walk(child, where)

    return list(walk({k: v for k, v in _tree().items() if k != "sources"}, ""))


def leg_value(leg: str, path: str) -> float | np.ndarray:
    """A number under `leg`, taking the rear variant where one exists; still in the front-left frame."""
    if leg[0] == "r":
        node = _tree()["leg"]["rear"]
        for key in path.split("."):
            node = node.get(key, {}) if isinstance(node, dict) else {}
        if "value" in node:
            return value(f"leg.rear.{path}")
    return value(f"leg.{path}")
