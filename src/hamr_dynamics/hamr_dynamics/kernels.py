"""Compiled kernels of a plant: traced in a tenth of a second, compiled once per machine and kept on disk under the hash of their text."""

from __future__ import annotations

import hashlib
import importlib.util
import os
import sys
import tempfile
from functools import cache
from pathlib import Path
from types import ModuleType

from hamr_description.numbers import value
from hamr_description.rates import SERVO_MS

from . import alignment, driver, straight
from .plant import Plant


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
def load(plant: Plant, environment: str, robots: int, dtype: str = "float64", h: float = SERVO_MS) -> ModuleType:
    """Module with the compiled `advance` and `look` of a plant (see `driver`).

    Args:
        environment: "ground" or "suspended".
        robots: robots per block; 1 for the one-robot kernel.
        dtype: "float64" or "float32".
        h: step, ms.
    """
    limit = value("actuator.neutral_voltage")
    return load_source(f"{plant.name}_{environment}_{dtype}_{robots}", driver.source(plant, environment, robots, dtype, h, limit))


def load_source(label: str, text: str) -> ModuleType:
    """The module of a source text, compiled at most once per machine: text and compiler decide, so no stale code can be found."""
    name = f"{label}_{hashlib.sha256(text.encode() + _compiler()).hexdigest()[:16]}"
    if name in sys.modules:
        return sys.modules[name]
    path = cache_folder() / f"{name}.py"
    if not path.exists():
        handle, temporary = tempfile.mkstemp(dir=path.parent, suffix=".tmp")
        with os.fdopen(handle, "w") as file:
            file.write(text)
        os.replace(temporary, path)  # whole or not at all, also with two processes at once
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


@cache
def _compiler() -> bytes:
    """What turns a text into machine code besides numba, which knows its own version."""
    return b"".join(Path(module.__file__).read_bytes() for module in (alignment, straight))
