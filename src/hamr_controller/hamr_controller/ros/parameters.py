"""Node parameters from a frozen dataclass: its fields are the parameters, their types and defaults count, nothing else is accepted.

A field is `parameter(default, "what it is, unit")`. With `live=True` it may be set while the node runs, else it is read-only.
Constraints between values stand in the dataclass's __post_init__, as ConfigError.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import field, fields, replace
from fnmatch import fnmatch
from pathlib import Path
from typing import Any, TypeVar, get_type_hints

import yaml
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter

from hamr_description.errors import ConfigError

P = TypeVar("P")
#: Parameters that ROS itself declares.
_OF_ROS = ("use_sim_time", "start_type_description_service", "qos_overrides")


def parameter(default: Any, what: str, *, live: bool = False) -> Any:
    """A dataclass field that is a node parameter."""
    return field(default=default, metadata={"what": what, "live": live})


def load(node: Node, kind: type[P], arguments: Sequence[str]) -> P:
    """Declare the parameters of a dataclass on a node and return them as given.

    Args:
        node: made with automatically_declare_parameters_from_overrides.
        kind: the dataclass.
        arguments: the process's own, for the names of its parameter files.

    Raises:
        ConfigError: an unknown name, a wrong type, a value out of bounds, a parameter file that says nothing to this node.
    """
    known = {entry.name: entry for entry in fields(kind)}
    given = {name: value.value for name, value in node.get_parameters_by_prefix("").items() if not name.startswith(_OF_ROS)}
    if unknown := sorted(set(given) - set(known)):
        raise ConfigError(f"{node.get_name()} has no parameter '{unknown[0]}'; it takes {', '.join(known)}.")
    _check_files(node, arguments)
    types = get_type_hints(kind)
    values = {name: _typed(name, value, types[name]) for name, value in given.items()}
    parameters = kind(**values)
    for name, entry in known.items():
        if name in given:
            node.undeclare_parameter(name)
        descriptor = ParameterDescriptor(description=entry.metadata["what"], read_only=not entry.metadata["live"])
        node.declare_parameter(name, _plain(getattr(parameters, name)), descriptor, ignore_override=True)
    return parameters


def follow(node: Node, parameters: P, changed: Callable[[P], None]) -> None:
    """Let live parameters be set while the node runs; a value that does not fit is refused with its sentence."""
    current = parameters
    types = get_type_hints(type(parameters))

    def on_set(changes: list[Parameter]) -> SetParametersResult:
        nonlocal current
        own = [change for change in changes if change.name in types]
        try:
            current = replace(current, **{change.name: _typed(change.name, change.value, types[change.name]) for change in own})
            changed(current)
        except ConfigError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    node.add_on_set_parameters_callback(on_set)


def _typed(name: str, value: Any, kind: Any) -> Any:
    """The value as the dataclass wants it: whole numbers are taken for real ones, arrays become tuples."""
    plain = _plain(value)
    if kind is float and type(plain) is int:
        return float(plain)
    if kind in (bool, int, float, str):
        if type(plain) is kind:
            return plain
    elif isinstance(plain, list):  # tuple[float, float]
        wanted = kind.__args__
        if len(plain) == len(wanted):
            return tuple(_typed(name, item, item_kind) for item, item_kind in zip(plain, wanted, strict=True))
    described = getattr(kind, "__name__", kind) if kind in (bool, int, float, str) else f"{len(kind.__args__)} numbers"
    raise ConfigError(f"Parameter '{name}' is {plain!r}; give it as {described}.")


def _plain(value: Any) -> Any:
    return list(value) if not isinstance(value, (bool, int, float, str, bytes)) and value is not None else value


def _check_files(node: Node, arguments: Sequence[str]) -> None:
    """rcl takes silently a file in which no key matches the node: a misspelt node name would run on defaults."""
    for flag, file in zip(arguments, arguments[1:], strict=False):
        if flag == "--params-file":
            keys = yaml.safe_load(Path(file).read_text()) or {}
            full = node.get_fully_qualified_name()
            if not any(fnmatch(full, pattern) or pattern == node.get_name() for pattern in keys):
                raise ConfigError(f"{file} has no parameters for {full}; it names {', '.join(keys) or 'no node'}.")
