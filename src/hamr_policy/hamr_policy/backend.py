"""From the name of a backend to simulated robots: the one place where policies meet simulators."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hamr_description.errors import ConfigError
from hamr_dynamics.batch import BatchSim

RESIDUAL = "residual"


def simulator(backend: str, n: int, *, residual: str | Path | None = None, dtype: type = np.float32) -> BatchSim:
    """n robots on the ground.

    Args:
        backend: full, simple, simple_published or residual.
        residual: model file of the residual backend, and of it alone.
        dtype: of the kernels; np.float32 is twice as fast.
    """
    if (backend == RESIDUAL) != (residual is not None):
        raise ConfigError(f"Backend '{backend}' {'needs a' if residual is None else 'takes no'} residual model file.")
    return BatchSim(backend, n, environment="ground", dtype=dtype)
