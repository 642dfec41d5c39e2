"""HAMR-simple, with or without its learned residual, as an engine behind the topics."""

from __future__ import annotations

from pathlib import Path

from hamr_description.errors import ConfigError
from hamr_dynamics.effects.effects_file import EffectsFile, refuse
from hamr_dynamics.engine import Engine, KernelEngine

BACKENDS = ("simple", "simple_published", "residual")


def make_engine(
    *,
    backend: str = "",
    engine: str = "kernel",
    environment: str = "ground",
    friction: float | None = None,
    residual: str = "",
    effects: str | Path | EffectsFile = "",
    seed: int = 0,
) -> Engine:
    """HAMR-simple, the published lumped fit, or HAMR-simple with a residual network.

    Args:
        backend: one of BACKENDS; empty means residual if a model file is given, else simple.
        engine: "kernel", or "mujoco" (without network only).
        environment, friction, effects, seed: as `hamr_sim_full.engines.make_engine`.
        residual: residual model file.
    """
    backend = backend or ("residual" if residual else "simple")
    if backend not in BACKENDS:
        raise ConfigError(f"Unknown backend '{backend}': known are {', '.join(BACKENDS)}.")
    if (backend == "residual") != bool(residual):
        raise ConfigError(f"Backend '{backend}' does not fit residual model '{residual}': residual needs a model file, the others none.")
    if engine == "kernel":
        robot: Engine = KernelEngine(_plant(backend, residual), environment=environment, friction=friction, effects=effects)
    elif engine == "mujoco" and backend != "residual":
        refuse(effects, engine)
        robot = _mujoco(backend, environment, friction)
    else:
        raise ConfigError(f"Engine '{engine}' cannot run backend '{backend}': use the kernel, or MuJoCo without a network.")
    robot.reset(seed)
    return robot


def _mujoco(backend: str, environment: str, friction: float | None) -> Engine:
    """MuJoCo is imported only where it is asked for."""
    if backend == "simple":
        from hamr_sim_residual.mujoco_simple import simple_engine

        return simple_engine(environment=environment, friction=friction)
    from hamr_sim_residual.mujoco_published import published_engine

    return published_engine(environment=environment, friction=friction)


def _plant(backend: str, residual: str):
    if backend != "residual":
        return backend
    from .residual_plant import residual_plant

    return residual_plant(residual)
