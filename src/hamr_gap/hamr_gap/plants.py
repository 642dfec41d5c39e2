"""Any machine of one or two joints: its model from a Python file, what was measured of it from tables.

The file holds a function that returns a `hamr_dynamics.machine.Machine`, such as `linear_machine` makes, and may hold `COLUMNS`, a
mapping from `time`, `drive` and sensor channels to the names that the tables give them (`columns.record_of`).
"""

from __future__ import annotations

import importlib.util
import shlex
from collections.abc import Callable, Sequence
from pathlib import Path

from hamr_description.errors import ConfigError
from hamr_dynamics import machine_kernel
from hamr_dynamics.machine import Machine, with_motion

from .data.columns import record_of
from .data.record import Record, joined
from .study import kept_apart, study


def load(said: str) -> tuple[Machine, dict]:
    """The machine that FILE.py:NAME makes, with sensors of rates and accelerations, and the file's `COLUMNS`. The file is run: give only
    what you trust.

    Raises:
        ConfigError: no such file or function, or it makes no machine; one sentence.
    """
    file, colon, name = said.rpartition(":")
    if not colon or not name.isidentifier() or not file.endswith(".py"):
        raise ConfigError(f"'{said}' is no plant; write FILE.py:NAME with NAME a function that returns a Machine.")
    if not Path(file).is_file():
        raise ConfigError(f"There is no plant file {file}; write one with a function {name}() that returns a Machine.")
    spec = importlib.util.spec_from_file_location(Path(file).stem, file)
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
        if not callable(getattr(module, name, None)):
            raise ConfigError(f"{file} has no function {name}; define one that returns a Machine.")
        machine = getattr(module, name)()
    except ConfigError:
        raise
    except Exception as error:  # whatever a user's file raises is one sentence to the user
        raise ConfigError(f"The plant {said} cannot be made: {type(error).__name__}: {error}; correct the file.") from error
    if not isinstance(machine, Machine):
        raise ConfigError(f"{name}() of {file} returns a {type(machine).__name__}; return a hamr_dynamics.machine.Machine.")
    try:
        machine_kernel.source(machine)
    except Exception as error:  # whatever goes wrong in a user's equations, likewise
        raise ConfigError(
            f"The equations of {said} cannot be compiled: {type(error).__name__}: {error}; `terms` must return tuples, made with "
            "+ - * / and the functions of hamr_dynamics.scalar, such as sin, sqrt and maximum."
        ) from error
    return with_motion(machine), dict(getattr(module, "COLUMNS", {}))


def run(
    plant: str, measured: Sequence[Path], out: Path, *, holdout: Sequence[Path] = (), report: Callable[[str], None] = lambda _: None
) -> dict:
    """Find, name, add and show for a machine of one's own.

    Args:
        plant: FILE.py:NAME. measured: tables, several as stretches of one record. out: folder for all that is found.
        holdout: tables that are opened only after the answer is fixed. report: told the stage.

    Returns:
        The content of `verdict.json`.

    Raises:
        BagError, ConfigError: one sentence.
    """
    kept_apart(measured, holdout)
    machine, columns = load(plant)

    def records(paths: Sequence[Path]) -> Record:
        first = record_of(machine, paths[0], columns)
        return joined([first, *(record_of(machine, path, columns, step=first.step) for path in paths[1:])])

    words = ["hamr", "gap", "--plant", plant, "--measured", *measured, *(("--holdout", *holdout) if holdout else ()), "--out", out]
    opened = (lambda: records(holdout)) if holdout else None
    return study(machine, records(measured), Path(out), holdout=opened, command=shlex.join(map(str, words)), report=report)
