"""What surrounds an effect: excitation, sensor noise and hidden changes of parameters."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from .case import JOINTS, Case
from .machine import TIME_SHIFT

#: Sensor noise, share of the stroke.
NOISE = (2e-4, 1e-2)
#: Spread of the factors (log-normal) and of the offsets: N mm, rad, mm.
SPREAD = {"drive_gain": 0.1, "stiffness": 0.08, "damping": 0.25, "inertia": 0.05, "sensor_gain": 0.01, "tip_gain": 0.01,
          "preload": 0.03, "bias": 0.01, "tip_bias": 0.005}  # fmt: skip
LATEST = 0.5  # ms


def conditions(case: Case, random: np.random.Generator) -> Case:
    """The case with excitation, noise and changes drawn."""
    noise = float(np.exp(random.uniform(*np.log(NOISE))))
    return replace(case, excitation=signal(case, random), noise=noise, changes=changes(random) if random.random() < 0.7 else {})


def signal(case: Case, random: np.random.Generator) -> dict:
    """White noise in 7 of 10 cases (half of them as published), mixes in the others; for nulls a gait in 1.

    A lone gait tells so little that parameters far beyond reason explain most effects: with effects it is left to the twins.
    """
    kind = random.random()
    seed = int(random.integers(2**31))
    if kind < 0.35:
        return {"kind": "noise", "seconds": case.seconds, "seed": seed}
    if kind < 0.7:
        band, std = float(random.uniform(20.0, 60.0)), float(random.uniform(35.0, 64.0))
        return {"kind": "noise", "seconds": case.seconds, "seed": seed, "band_hz": band, "std": std}
    if kind < 0.9 or case.group != "null":
        return {"kind": "mix", "seconds": case.seconds, "seed": seed, "amplitude": float(random.uniform(35.0, 60.0))}
    gait, hz = ("trot", "pronk")[random.integers(2)], float(random.uniform(3.0, 35.0))
    return {"kind": gait, "seconds": case.seconds, "frequency_hz": hz, "amplitude": float(random.uniform(40.0, 80.0))}


def changes(random: np.random.Generator, joints: Sequence[str] = JOINTS, kinds: Collection[str] = tuple(SPREAD)) -> dict[str, float]:
    """Hidden changes of the kinds at the joints, and a common time shift in a third of the draws."""
    drawn = {}
    for kind in kinds:
        for joint in joints:
            x = float(np.clip(random.standard_normal(), -2.5, 2.5)) * SPREAD[kind]
            drawn[f"{kind}.{joint}"] = x if kind in ("preload", "bias", "tip_bias") else float(np.exp(x))
    if random.random() < 1 / 3:
        drawn[TIME_SHIFT] = float(random.uniform(0.05, LATEST))
    return drawn


def null(case: Case, random: np.random.Generator) -> Case:
    """No effect, by turns: nothing, changes of parameters alone, each bad noise, the coarser step of a plain simulator."""
    turns = ("nothing", "changes", "coloured", "changes", "heavy", "nothing", "dropouts", "changes", "repeats", "coarse")
    turn = turns[case.seed % len(turns)]
    if turn == "nothing":
        return replace(case, changes={})
    if turn == "changes":
        return replace(case, changes=changes(random))
    return replace(case, step=0.05) if turn == "coarse" else replace(case, noise_kind=turn)
