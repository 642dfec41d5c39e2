"""HAMR-full as an engine behind the topics."""

from __future__ import annotations

from pathlib import Path

from hamr_description.errors import ConfigError
from hamr_dynamics.effects.effects_file import EffectsFile, refuse
from hamr_dynamics.engine import Engine, KernelEngine

ENGINES = ("kernel", "mujoco")


def make_engine(
    *,
    engine: str = "kernel",
    environment: str = "ground",
    friction: float | None = None,
    effects: str | Path | EffectsFile = "",
    seed: int = 0,
) -> Engine:
    """HAMR-full.

    Args:
        engine: "kernel" (compiled, closed-form transmission) or "mujoco" (loop closures as constraints).
        environment: "ground" or "suspended".
        friction: Coulomb coefficient of the feet; None takes numbers.yaml.
        effects: effects file, or what was read from one; empty for none; only with the kernel.
        seed: of the initial state.
    """
    if engine == "kernel":
        robot: Engine = KernelEngine("full", environment=environment, friction=friction, effects=effects)
    elif engine == "mujoco":
        refuse(effects, engine)
        from .mujoco_full import full_engine  # MuJoCo only where it is asked for

        robot = full_engine(environment=environment, friction=friction)
    else:
        raise ConfigError(f"Unknown engine '{engine}': known are {', '.join(ENGINES)}.")
    robot.reset(seed)
    return robot
