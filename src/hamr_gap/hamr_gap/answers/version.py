"""Which code an answer comes from: what an interrupted call had finished is taken up only by the code that found it."""

from __future__ import annotations

import hashlib
from functools import cache
from importlib.util import find_spec
from pathlib import Path

#: Where an answer comes from, besides data: the robot's numbers, the physics with its library of effects, the models, the workflow.
PACKAGES = ("hamr_description", "hamr_dynamics", "hamr_sim_full", "hamr_sim_residual", "hamr_gap")
SUFFIXES = (".py", ".yaml", ".json")


@cache
def code() -> str:
    """Hash of the sources, numbers and models of `PACKAGES`."""
    digest = hashlib.sha256()
    for package in PACKAGES:
        for file in sorted(Path(find_spec(package).origin).parent.rglob("*")):
            if file.suffix in SUFFIXES:
                digest.update(file.read_bytes())
    return digest.hexdigest()
