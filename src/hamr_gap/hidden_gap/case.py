"""What a hidden case is, and what a run of it gives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hamr_description.names import AXES

#: The leg's joints in canonical order; every (.., 2) array has this order.
LEG = "fl"
JOINTS = tuple(f"{LEG}_{axis}" for axis in AXES)
CHANNELS = ("angles", "deflections")


@dataclass(frozen=True, slots=True)
class Effect:
    """One law at one place.

    Attributes:
        family: the name that the workflow should give; "outside" where there is none.
        joints: where it acts, of JOINTS.
        law: this package's own formula.
        parameters: of the law (g, mm, ms, N, V, rad).
    """

    family: str
    joints: tuple[str, ...]
    law: str
    parameters: dict[str, float]


@dataclass(frozen=True, slots=True)
class Hidden:
    """What is hidden in a machine, and how that is driven; equal cases give equal numbers.

    Attributes:
        name: group and seed, for the answers' file only.
        group: one of `draw.GROUPS` or `ground.GROUPS`.
        seed: of the draw, the excitation and the noise.
        effects: what is hidden; empty for a null.
        changes: hidden changes of parameters, `machine.KINDS`, and the common time shift.
        seconds: length of the run.
        excitation: arguments of hamr_bags.excitation.excitation.
        noise: standard deviation of the encoders' noise as a share of the stroke.
    """

    name: str
    group: str
    seed: int
    effects: tuple[Effect, ...]
    changes: dict[str, float]
    seconds: float
    excitation: dict
    noise: float


@dataclass(frozen=True, slots=True)
class Case(Hidden):
    """A hidden suspended leg and how it is measured.

    Attributes:
        noise_kind: of `noise.KINDS`.
        channels: those recorded, of CHANNELS.
        strength: asked, in floors.
        reached: strength of the machine as drawn, and of each effect in the others' company.
        step: integration step, ms.
    """

    noise_kind: str
    channels: tuple[str, ...]
    strength: float
    reached: tuple[float, ...] = ()
    step: float = 0.025


@dataclass(frozen=True, slots=True)
class Truth:
    """A run at 4 kHz: time (n,) s, volts (n, 2) V, angles (n, 2) rad, tips (n, 2) m; columns as JOINTS. Lost samples are absent rows."""

    time: np.ndarray
    volts: np.ndarray
    angles: np.ndarray
    tips: np.ndarray
