"""From the name of a backend to simulated robots: the one place where policies meet simulators."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np

from hamr_description.errors import ConfigError
from hamr_dynamics.batch import BatchSim
from hamr_dynamics.effects.effects_file import EffectsFile
from hamr_sim_residual.residual_plant import SHIPPED, residual_plant

RESIDUAL = "residual"


def simulator(
    backend: str, n: int, *, residual: str | Path = "", effects: str | Path | EffectsFile = "", dtype: type = np.float32
) -> BatchSim:
    """n robots on the ground.

    Args:
        backend: full, simple, simple_published or residual.
        residual: model file of the residual backend; empty for the shipped one.
        effects: effects file, or what was read from one; empty for none.
        dtype: of the kernels; np.float32 is twice as fast.

    Raises:
        ConfigError: there is no such backend, or it takes no residual model. ModelError: the model does not fit.
    """
    if residual and backend != RESIDUAL:
        raise ConfigError(f"Backend '{backend}' takes no residual model file: leave '{residual}' out, or choose backend '{RESIDUAL}'.")
    plant = residual_plant(residual or SHIPPED) if backend == RESIDUAL else backend
    return BatchSim(plant, n, environment="ground", dtype=dtype, effects=effects)


def residual_digest(backend: str, residual: str | Path = "") -> str:
    """SHA-256 of the residual model that a backend runs, 16 hex digits; empty where it runs none."""
    return hashlib.sha256(Path(residual or SHIPPED).read_bytes()).hexdigest()[:16] if backend == RESIDUAL else ""
