"""What columns of a table say about a machine: their roles and units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from hamr_description.errors import BagError, ConfigError
from hamr_dynamics.machine import Machine

from .clock import Clock
from .read_table import read_columns
from .readings import rounding
from .record import Record
from .si import dimension_of, si_of

#: Units a column may have: factor to SI, and the SI unit.
UNITS = {
    "s": (1.0, "s"), "ms": (1e-3, "s"), "us": (1e-6, "s"), "m": (1.0, "m"), "cm": (1e-2, "m"), "mm": (1e-3, "m"), "um": (1e-6, "m"),
    "rad": (1.0, "rad"), "mrad": (1e-3, "rad"), "deg": (np.pi / 180.0, "rad"), "V": (1.0, "V"), "mV": (1e-3, "V"), "kV": (1e3, "V"),
    "A": (1.0, "A"), "mA": (1e-3, "A"), "N": (1.0, "N"), "mN": (1e-3, "N"), "kN": (1e3, "N"), "N*m": (1.0, "N*m"), "mN*m": (1e-3, "N*m"),
    "Pa": (1.0, "Pa"), "kPa": (1e3, "Pa"), "1": (1.0, "1"), "m/s": (1.0, "m/s"), "cm/s": (1e-2, "m/s"), "mm/s": (1e-3, "m/s"),
    "rad/s": (1.0, "rad/s"), "deg/s": (np.pi / 180.0, "rad/s"), "rpm": (np.pi / 30.0, "rad/s"), "m/s^2": (1.0, "m/s^2"),
    "mm/s^2": (1e-3, "m/s^2"), "g": (9.80665, "m/s^2"), "rad/s^2": (1.0, "rad/s^2"), "deg/s^2": (np.pi / 180.0, "rad/s^2"),
}  # fmt: skip


def record_of(
    machine: Machine, path: str | Path, columns: Mapping[str, str | float] | None = None, *, step: float | None = None
) -> Record:
    """What a table says about a machine.

    The table has the columns `time`, `drive` (`drive.JOINT` for each of two joints) and one for each sensor channel by its name, or for
    some of them, at least one of each joint's motion. A name may carry its unit, "drive [mV]"; without one it is in the machine's own.

    Args:
        columns: role -> name of the column in this table, where it has another, with its unit if it has one ("t [ms]"); for `time` a
            number of seconds between rows, where no column says it; for a drive a number, where it is the same all the time.
        step: T between samples where the table's times are uneven; their usual one if not given.

    Raises:
        BagError, ConfigError: a column is missing or makes no sense; one sentence.
    """
    table = {_split(name)[0]: (name, x) for name, x in read_columns(path).items()}
    columns = dict(columns or {})
    drives = ("drive",) if len(machine.joints) == 1 else tuple(f"drive.{joint}" for joint in machine.joints)
    roles = {"time": "T", **dict.fromkeys(drives, "U"), **{name: dimension_of(machine, name) for name in machine.channels}}
    if unknown := set(columns) - set(roles):
        raise ConfigError(f"The mapping names '{min(unknown)}', which {machine.name} has not: known are {', '.join(roles)}.")

    def column(role: str) -> np.ndarray | None:
        said = columns.get(role, role)
        name, unit = _split(str(said))
        if name not in table:
            if role in columns or role not in machine.channels:
                raise BagError(f"{path} has no column '{name}' for {role}; it has {', '.join(table)}: name it so, or map it.")
            return None
        own, x = table[name]
        return x * _factor(machine, roles[role], unit or _split(own)[1], f"column '{name}' of {path}")

    rows = len(next(iter(table.values()))[1])
    used = np.column_stack([np.full(rows, float(x)) if _is_number(x := columns.get(role)) else column(role) for role in drives])
    readings = {name: x for name in machine.channels if (x := column(name)) is not None}
    moved = {motion[0] for name in readings if (motion := machine.motion_of(name))}
    if missing := [name for j, name in enumerate(machine.channels[: len(machine.joints)]) if j not in moved]:
        raise BagError(f"{path} has no column for the sensor {missing[0]}; it has {', '.join(table)}: name it so, or map it.")
    read = np.column_stack(list(readings.values()))
    if _is_number(columns.get("time")):
        return Record(used, read, float(columns["time"]) / machine.to_si["T"], tuple(readings), rest=False)
    clock = Clock.of(column("time"), str(path), step)
    taken = Record(used, read, clock.step, tuple(readings), rest=False, breaks=clock.breaks, uneven=clock.uneven)
    used, read, breaks = clock.evened(taken.drives, taken.readings)
    steps = tuple(rounding(x) for x in taken.readings.T) if clock.uneven else ()
    return replace(taken, drives=used, readings=read, breaks=breaks, rounding=steps)


def _is_number(x: object) -> bool:
    return isinstance(x, int | float)


def _split(name: str) -> tuple[str, str]:
    """("drive", "mV") of "drive [mV]"."""
    head, bracket, unit = name.partition("[")
    return head.strip(), unit.strip().removesuffix("]").strip() if bracket else ""


def _factor(machine: Machine, dimension: str, unit: str, where: str) -> float:
    """What a column's numbers are times to be in the machine's units."""
    if not unit:
        return 1.0
    own, wanted = si_of(dimension, machine)
    if unit not in UNITS and unit != wanted:
        raise BagError(f"The unit '{unit}' of {where} is not known; write one of {', '.join(UNITS)}.")
    (factor, base), (into, wanted_base) = (UNITS.get(name, (1.0, name)) for name in (unit, wanted))
    if base != wanted_base:
        raise BagError(f"The unit '{unit}' of {where} cannot be made {wanted}, as {machine.name} has it; correct one of them.")
    return factor / into / own
