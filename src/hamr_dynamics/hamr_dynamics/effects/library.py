"""The effects found in this folder, by name."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from types import MappingProxyType

from hamr_description.errors import ConfigError

from .law import Effect, Form

_FOLDER = __package__


@cache
def library() -> Mapping[str, Effect]:
    """name -> effect, in alphabetical order."""
    modules = (import_module(f"{_FOLDER}.{info.name}") for info in iter_modules(import_module(_FOLDER).__path__))
    found = {module.EFFECT.name: module.EFFECT for module in modules if hasattr(module, "EFFECT")}
    return MappingProxyType(dict(sorted(found.items())))


def find(effect: str, form: str = "") -> Form:
    """A form by effect name (its first form if not said); ConfigError lists what there is."""
    if effect not in library():
        raise ConfigError(f"There is no effect '{effect}': known are {', '.join(library())}.")
    forms = library()[effect].forms
    for candidate in forms:
        if candidate.name == (form or forms[0].name):
            return candidate
    raise ConfigError(f"Effect '{effect}' has no form '{form}': known are {', '.join(f.name for f in forms)}.")
