"""Compiled kernels of a plant, cached on disk: source text traced once per version of the physics, machine code once per machine."""

from __future__ import annotations

import hashlib
import importlib.util
import inspect
import os
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import ModuleType

from hamr_description.numbers import value
from hamr_description.rates import SERVO_MS

from . import driver
from .plant import Plant, flatten

PACKAGES = ("hamr_description", "hamr_dynamics")


def cache_folder() -> Path:
    """Where generated kernels lie: $HAMR_CACHE, or the user's cache folder, or a temporary one if neither can be written."""
    home = os.environ.get("HAMR_CACHE") or os.path.join(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "hamr")
    folder = Path(home) / "kernels"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if os.access(folder, os.W_OK):
            return folder
    except OSError:
        pass
    folder = Path(tempfile.gettempdir()) / f"hamr-{os.getuid()}" / "kernels"
    folder.mkdir(parents=True, exist_ok=True)
    return folder


@cache
def _fingerprint(folders: tuple[Path, ...]) -> str:
    """Hash of every source file that shapes a kernel."""
    digest = hashlib.sha256()
    for folder in folders:
        for path in sorted([*folder.glob("*.py"), *folder.glob("*.yaml")]):
            digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()


def _key(plant: Plant, *settings: object) -> str:
    home = Path(inspect.getsourcefile(plant.leg)).parent
    folders = tuple(Path(importlib.util.find_spec(p).origin).parent for p in PACKAGES) + (home,)
    numbers = [sorted(flatten(plant.parameters(leg)).items()) for leg in ("fl", "rl")]
    text = repr((_fingerprint(folders), numbers, plant.tunable, plant.network, sys.version_info[:2], *settings))
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def load(plant: Plant, environment: str, robots: int, dtype: str = "float64", h: float = SERVO_MS) -> ModuleType:
    """Module with the compiled `advance` and `look` of a plant (see `driver`).

    Args:
        environment: "ground" or "suspended".
        robots: robots per block; 1 for the one-robot kernel.
        dtype: "float64" or "float32".
        h: step, ms.
    """
    limit = value("actuator.neutral_voltage")
    label = f"{plant.name}_{environment}_{dtype}_{robots}"
    return load_source(label, lambda: driver.source(plant, environment, robots, dtype, h, limit), plant, environment, robots, dtype, h, limit)


def load_source(label: str, write: Callable[[], str], plant: Plant, *settings: object) -> ModuleType:
    """The module whose text `write` gives, from the cache if plant, settings and the sources of the physics are unchanged."""
    name = f"{label}_{_key(plant, *settings)}"
    if name in sys.modules:
        return sys.modules[name]
    path = cache_folder() / f"{name}.py"
    if not path.exists():
        handle, temporary = tempfile.mkstemp(dir=path.parent, suffix=".tmp")
        with os.fdopen(handle, "w") as file:
            file.write(write())
        os.replace(temporary, path)  # whole or not at all, also with two processes at once
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module
