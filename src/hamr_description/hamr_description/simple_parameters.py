"""Constants of HAMR-simple: read from simple.yaml, which a script derives from HAMR-full's linear limit."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib import resources

import yaml

from .errors import ConfigError


@cache
def simple_parameters() -> Mapping:
    """The groups `chassis`, `front` and `rear` of simple.yaml, in the shape that mjcf_simple.simple takes."""
    try:
        return yaml.safe_load(resources.files(__package__).joinpath("simple.yaml").read_text())
    except FileNotFoundError:
        raise ConfigError("hamr_description has no simple.yaml; derive it from HAMR-full with `hamr derive-simple`.") from None
