"""What a plant is to the rest of the dynamics, and the registry in which plants make themselves known by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from importlib import import_module

from hamr_description.errors import ConfigError


@dataclass(frozen=True, slots=True, eq=False)
class Plant:
    """A robot model, leg by leg; the same only if the same object.

    Attributes:
        name: as on the command line.
        leg: `(q, v, drive, parameters) -> Leg` over any scalar type, front-left frame (`hamr_dynamics.leg`).
        parameters: leg name -> parameters of that leg; numbers or tuples of numbers.
        chassis: mass (g), com (3,) mm, inertia (6,) g mm^2 about it.
        tunable: parameters that may differ from lane to lane (everything else is compiled in).
        network: torque network in place of the drive, or None (`hamr_sim_residual.network`).
        effects: whether its kernels carry the bank of effects (`with_effects`).
    """

    name: str
    leg: Callable
    parameters: Callable[[str], Mapping]
    chassis: Mapping
    tunable: tuple[str, ...] = ()
    network: object | None = field(default=None)
    effects: bool = False


#: Where each backend lives; its package registers it on import.
HOMES = {
    "full": "hamr_sim_full.plants", "simple": "hamr_sim_residual.plants", "simple_published": "hamr_sim_residual.plants",
    "residual": "hamr_sim_residual.residual_plant",
}  # fmt: skip
_REGISTRY: dict[str, Callable[[], Plant]] = {}


def register(name: str, factory: Callable[[], Plant]) -> None:
    """Makes a plant known."""
    _REGISTRY[name] = factory
    plant.cache_clear()


@cache
def plant(name: str) -> Plant:
    """The plant of a name; ConfigError lists the known ones."""
    if name not in _REGISTRY and name in HOMES:
        import_module(HOMES[name])
    if name not in _REGISTRY:
        raise ConfigError(f"Unknown backend '{name}': known are {', '.join(sorted({*HOMES, *_REGISTRY}))}.")
    return _REGISTRY[name]()


@cache
def with_effects(model: Plant) -> Plant:
    """The same robot with the bank of effects in its kernels; always the same object for the same robot."""
    return model if model.effects else replace(model, effects=True)


def flatten(parameters: Mapping) -> dict[str, float]:
    """Parameters as name -> float; tuples become name.0, name.1, ..."""
    flat = {}
    for name, number in parameters.items():
        if isinstance(number, tuple):
            flat |= {f"{name}.{i}": float(x) for i, x in enumerate(number)}
        else:
            flat[name] = float(number)
    return flat


def unflatten(flat: Mapping, like: Mapping) -> dict:
    """Inverse of `flatten`, with scalars of any type."""
    return {
        name: tuple(flat[f"{name}.{i}"] for i in range(len(number))) if isinstance(number, tuple) else flat[name]
        for name, number in like.items()
    }
