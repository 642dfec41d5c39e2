"""Constants of HAMR-simple: simple.yaml, which `python -m hamr_sim_residual.derive` makes from HAMR-full's linear limit."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib import resources

import yaml


@cache
def simple_constants() -> Mapping[str, Mapping]:
    """Groups `chassis`, `front` and `rear`; legs in the front-left leg's frame, (swing, lift) pairs (g, mm, ms, N, V, rad)."""
    return yaml.safe_load(resources.files(__package__).joinpath("simple.yaml").read_text())
