"""HAMR-simple driven by a learned torque law, as a plant: `residual_plant("model.json")`."""

from __future__ import annotations

from functools import cache
from importlib import resources
from pathlib import Path

from hamr_dynamics.plant import Plant, register

from . import model_file
from .network import Network
from .plants import TUNABLE, simple
from .simple import rigid_leg, simple_constants, simple_parameters

#: The model that ships, and the one that backend "residual" means without a file.
SHIPPED = Path(str(resources.files(__package__))) / "models" / "residual.json"
DRIVE = "torque_per_volt"


def torque_parameters(leg: str) -> dict:
    """HAMR-simple's parameters without its drive."""
    return {name: x for name, x in simple_parameters(leg).items() if name != DRIVE}


def torque_driven(network: Network | None = None) -> Plant:
    """HAMR-simple with hip torques (N mm) for drive, or with a network that makes them from its state and the voltages."""
    tunable = tuple(name for name in TUNABLE if name != DRIVE)
    return Plant("residual", rigid_leg, torque_parameters, simple_constants()["chassis"], tunable, network)


@cache
def _load(path: Path, changed: int) -> Plant:
    return torque_driven(model_file.load(path).network)


def residual_plant(path: str | Path = "") -> Plant:
    """The residual plant of a model file; plain HAMR-simple for an empty path. ModelError if the file does not fit."""
    if not path:
        return simple()
    path = Path(path)
    return _load(path, path.stat().st_mtime_ns if path.exists() else 0)


register("residual", lambda: residual_plant(SHIPPED))
