"""The truth about HAMR-simple and HAMR-full, computed and not searched: what full has that simple lacks, in hip angles.

    python -m hamr_gap.flagship            tables of docs/flagship.md

Inertia, stiffness and transmission of full are reduced to hip angles over the stroke, fitted by the library's own laws, and put
into simple singly and in groups.
"""

from __future__ import annotations

import sys
from itertools import combinations

import numpy as np
import tyro

from hamr_bags.excitation import excitation
from hamr_description.names import JOINTS, drive_sign
from hamr_description.numbers import value
from hamr_description.rates import SERVO_MS
from hamr_dynamics import machine_kernel
from hamr_dynamics.effects.configuration_dependent_transmission import POWERS
from hamr_dynamics.effects.law import Scales
from hamr_dynamics.machine import Machine
from hamr_sim_full.actuator import bender

from .legs import machine_of
from .parameters import Candidate

GRID = np.linspace(-0.25, 0.25, 11)  # rad, of both angles
WINDOW_MS = 8.0
EFFECTS = {
    "inertia": Candidate("configuration_dependent_inertia", "polynomial", (0, 1)),
    "stiffness": Candidate("configuration_dependent_stiffness", "potential", (0, 1)),
    "transmission": Candidate("configuration_dependent_transmission", "map", (0, 1)),
}


def scales() -> Scales:
    """Of HAMR's legs under the paper's white noise, for shapes that do not matter here."""
    return Scales(0.06, 0.1, 1.5, 60.0, 12e3)


def differences(simple: Machine, full: Machine) -> dict[str, dict[str, float]]:
    """Parameters of the library's laws that turn simple into full, by least squares over the stroke; effect -> row -> value.

    Transmission: travel of each actuator, in the angle that it makes at rest. Stiffness: what is left of full's static force after
    its actuators' springs act through that map. Inertia: full's mass matrix minus simple's.
    """
    points = [(a, b) for a in GRID for b in GRID]
    zero = (0.0, 0.0)
    ratio = np.array([(full.outputs((e, 0.0), zero)[2], full.outputs((0.0, e), zero)[3]) for e in (1e-6,)])[0] / 1e-6
    travel = np.array([np.array(full.outputs(q, zero)[2:]) / ratio - q for q in points])
    travel -= np.array(full.outputs(zero, zero)[2:]) / ratio
    powers = list(POWERS)
    basis = np.array([[a**i * b**j for i, j in powers] for a, b in points])
    found: dict[str, dict[str, float]] = {name: {} for name in EFFECTS}
    stem = "configuration_dependent_transmission.map"
    spring = (value("actuator.stiffness") + bender().rail_stiffness) * ratio**2  # of the actuators, in hip angles, N mm/rad
    own = np.array([full.diagonal(full.at_rest.stiffness, j) for j in (0, 1)])
    for i in (0, 1):
        for (a, b), c in zip(powers, np.linalg.lstsq(basis, travel[:, i], rcond=None)[0], strict=True):
            found["transmission"][f"{stem}.a{i + 1}_{a}{b}.0"] = c
        found["transmission"][f"{stem}.share{i + 1}.0"] = min(1.0, spring[i] / own[i])
    rest = np.array(full.terms(zero, zero, zero, zero).force)
    terms = [(i, n - i) for n in (3, 4) for i in range(n, -1, -1)]
    rows, force = [], []
    coefficients = np.array([[found["transmission"][f"{stem}.a{i + 1}_{a}{b}.0"] for a, b in powers] for i in (0, 1)])
    for s, r in points:
        static = np.array(full.terms((s, r), zero, zero, zero).force) - rest
        bend = coefficients @ [s**i * r**j for i, j in powers]
        slope = np.array([[c @ _slopes(powers, s, r, k) for k in (0, 1)] for c in coefficients])
        acting = spring * (np.array([s, r]) + bend)
        through = -(slope.T @ acting) - spring * bend  # beyond what linear springs do
        linear = -np.array([[own[0], full.at_rest.stiffness[1]], [full.at_rest.stiffness[1], own[1]]]) @ [s, r]
        rows += [[-i * s ** max(i - 1, 0) * r**j for i, j in terms], [-j * s**i * r ** max(j - 1, 0) for i, j in terms]]
        force += list(static - linear - through)
    for (i, j), c in zip(terms, np.linalg.lstsq(np.array(rows), np.array(force), rcond=None)[0], strict=True):
        found["stiffness"][f"configuration_dependent_stiffness.potential.c{i}{j}.0"] = c
    extra = np.array([np.subtract(full.terms(q, zero, zero, zero).mass, simple.terms(q, zero, zero, zero).mass) for q in points])
    squares = [(1, 0), (0, 1), (2, 0), (1, 1), (0, 2)]
    basis = np.array([[1.0, *(a**i * b**j for i, j in squares)] for a, b in points])
    for e, name in enumerate(("11", "12", "22")):
        for (a, b), c in zip(squares, np.linalg.lstsq(basis, extra[:, e], rcond=None)[0][1:], strict=True):
            found["inertia"][f"configuration_dependent_inertia.polynomial.m{name}_{a}{b}.0"] = c
    return found


def _slopes(powers, s: float, r: float, k: int) -> np.ndarray:
    return np.array([(i * s ** max(i - 1, 0) * r**j) if k == 0 else (j * s**i * r ** max(j - 1, 0)) for i, j in powers])


def ablate(simple: Machine, full: Machine, found: dict[str, dict[str, float]], *, seconds: float, seed: int) -> dict[tuple, tuple]:
    """Mean squared error of the hip angles (rad^2) of simple with each group of effects against full: (free run, windows of 8 ms).

    Windows start from full's state; the excitation is the paper's white noise.
    """
    columns = [JOINTS.index(j) for j in simple.joints]
    drives = (excitation("noise", seconds=seconds, seed=seed).voltages[:, columns] - value("actuator.neutral_voltage")) * drive_sign("fl")
    truth = machine_kernel.simulate(full, drives, full.neutral(scales())[None], step=SERVO_MS, substeps=1)[0][:, :2]
    rate = np.gradient(truth, SERVO_MS, axis=0)
    window = int(WINDOW_MS / SERVO_MS)
    starts = np.arange(2000, len(truth) - window - 1, 4 * window)
    state = np.zeros((len(starts), len(simple.state_rows)))
    for j in (0, 1):
        state[:, simple.state_rows.index(f"q.{j}")] = truth[starts, j]
        state[:, simple.state_rows.index(f"v.{j}")] = rate[starts, j]
    result = {}
    for size in range(len(found) + 1):
        for group in combinations(found, size):
            row = simple.neutral(scales())
            for name in group:
                for key, x in found[name].items():
                    row[simple.parameter_rows.index(key)] = x
            free = machine_kernel.simulate(simple, drives, row[None], step=SERVO_MS, substeps=1)[0][:, :2]
            short = machine_kernel.simulate(
                simple, drives, np.tile(row, (len(starts), 1)), step=SERVO_MS, substeps=1, first=starts, start=state, samples=window
            )
            error = short[:, :, :2] - np.stack([truth[k : k + window] for k in starts])
            result[group] = float(np.mean((free - truth) ** 2)), float(np.mean(error**2))
    return result


def main(seconds: float = 3.0, seed: int = 3) -> None:
    """Prints the tables."""
    simple, full = machine_of("simple", "fl"), machine_of("full", "fl")
    found = differences(simple, full)
    say = sys.stdout.write
    say("| angle, rad | M11, g mm2 | M22 | K11, N mm/rad | K22 | swing travel over angle | lift travel over angle |\n")
    say("|---|---|---|---|---|---|---|\n")
    zero = (0.0, 0.0)
    for a in GRID[::2]:
        swing, lift = full.terms((a, 0.0), zero, zero, zero), full.terms((0.0, a), zero, zero, zero)
        tips = [full.outputs((a, 0.0), zero)[2], full.outputs((0.0, a), zero)[3]] if a else [np.nan, np.nan]
        say(f"| {a:.2f} | {swing.mass[0]:.3f} | {lift.mass[2]:.3f} | {swing.stiffness[0]:.3f} | {lift.stiffness[2]:.3f} | "
            f"{tips[0] / a if a else np.nan:.3f} | {tips[1] / a if a else np.nan:.3f} |\n")  # fmt: skip
    errors = ablate(simple, full, found, seconds=seconds, seed=seed)
    say("\n| simple with | free run, rad2 | 8 ms, rad2 | 8 ms, times lower |\n|---|---|---|---|\n")
    for group, (free, short) in errors.items():
        say(f"| {' + '.join(group) or 'nothing'} | {free:.3g} | {short:.3g} | {errors[()][1] / short:.3g} |\n")


if __name__ == "__main__":
    tyro.cli(main)
