"""The truth about HAMR-simple and HAMR-full, computed and not searched: what full has that simple lacks, in hip angles.

    python -m hamr_gap.flagship            first two tables of docs/flagship.md

Inertia, stiffness, damping and transmission of full are reduced to hip angles over the stroke; the library's own laws are fitted to
them and put into simple singly and in groups.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from itertools import combinations
from typing import Literal

import numpy as np
import tyro

from hamr_bags.excitation import excitation
from hamr_description.names import JOINTS, drive_sign
from hamr_description.numbers import value
from hamr_description.rates import SERVO_MS
from hamr_dynamics import machine_kernel
from hamr_dynamics.effects.configuration_dependent_inertia import ENTRIES
from hamr_dynamics.effects.configuration_dependent_inertia import POWERS as OF_MASS
from hamr_dynamics.effects.law import Pair, Scales
from hamr_dynamics.machine import Machine
from hamr_sim_full.actuator import bender

from .fitting.parameters import Candidate
from .legs import machine_of

GRID = np.linspace(-0.4, 0.4, 17)  # rad, of both angles: the paper's white noise goes to 0.5 at most, and two standard deviations are 0.37
SMALL = 1e-4  # rad, of differences
WINDOW_MS = 8.0
EFFECTS = {
    "inertia": Candidate("configuration_dependent_inertia", "polynomial", (0, 1)),
    "stiffness": Candidate("configuration_dependent_stiffness", "potential", (0, 1)),
    "transmission": Candidate("configuration_dependent_transmission", "fine_map", (0, 1)),
}
ZERO = (0.0, 0.0)


def scales() -> Scales:
    """Of HAMR's legs under the paper's white noise, for shapes that do not matter here."""
    return Scales(0.06, 0.1, 1.5, 60.0, 12e3)


def static(machine: Machine, q: tuple) -> np.ndarray:
    """(2, ...) force at hip angles without drive or motion, N mm."""
    still = (np.zeros_like(q[0]),) * 2
    return np.array(machine.terms(q, still, still, still).force)


def reduced(full: Machine, q: tuple[float, float]) -> tuple[float, ...]:
    """M11, M12, M22 (g mm^2), K11, K22 (N mm/rad), D11, D22 (N mm ms/rad), and the slope of each actuator's travel in its own angle
    (mm/rad), at hip angles q."""
    at, (s, r) = full.terms(q, ZERO, ZERO, ZERO), q
    ahead, behind = (((s + e, r), (s, r + e)) for e in (SMALL, -SMALL))
    rises = [static(full, y)[j] - static(full, x)[j] for j, (x, y) in enumerate(zip(ahead, behind, strict=True))]
    climbs = [full.outputs(x, ZERO)[2 + j] - full.outputs(y, ZERO)[2 + j] for j, (x, y) in enumerate(zip(ahead, behind, strict=True))]
    return (*at.mass, *(x / (2 * SMALL) for x in rises), at.damping[0], at.damping[2], *(x / (2 * SMALL) for x in climbs))


def differences(simple: Machine, full: Machine, *, lever: str = "fine_map") -> dict[str, dict[str, float]]:
    """Parameters of the library's laws that turn simple into full, by least squares over the stroke; effect -> row -> value.

    `lever` is the form of the transmission.

    Transmission: travel of each actuator, in the angle that it makes at rest. Stiffness: what is left of full's static force after
    its actuators' springs act through that map. Inertia: full's mass matrix minus simple's.
    """
    q = tuple(x.ravel() for x in np.meshgrid(GRID, GRID, indexing="ij"))
    still = (np.zeros_like(q[0]),) * 2
    own = tuple(float(full.diagonal(full.at_rest.stiffness, j)) for j in (0, 1))
    ratio = np.array(reduced(full, ZERO)[-2:])  # mm/rad
    spring = (value("actuator.stiffness") + bender().rail_stiffness) * ratio**2  # of the actuators, in hip angles, N mm/rad

    effects = EFFECTS | {"transmission": replace(EFFECTS["transmission"], form=lever)}
    powers = [(int(x.name[3]), int(x.name[4])) for x in effects["transmission"].law.parameters if x.name.startswith("a1_")]
    travel = (np.array(full.outputs(q, ZERO)[2:]).T - full.outputs(ZERO, ZERO)[2:]) / ratio - np.transpose(q)
    bend = {f"share{i + 1}": min(1.0, spring[i] / own[i]) for i in (0, 1)}
    for i, found in enumerate(_fitted(_terms(q, powers), travel).T):
        bend |= {f"a{i + 1}_{a}{b}": c for (a, b), c in zip(powers, found, strict=True)}

    through = effects["transmission"].law.law(Pair(q, still, still, own, ZERO, SERVO_MS), bend, ())[0].force
    bent = static(full, q).T - static(full, ZERO) + np.transpose(q) * own - np.transpose(through)
    degrees = [(int(x.name[1]), int(x.name[2])) for x in effects["stiffness"].law.parameters]
    slopes = np.concatenate([-_terms(q, degrees, by) for by in (0, 1)])
    springs = {f"c{a}{b}": c for (a, b), c in zip(degrees, _fitted(slopes, bent.T.ravel()), strict=True)}

    extra = np.subtract(full.terms(q, still, still, still).mass, simple.terms(q, still, still, still).mass)
    constant_too = _fitted(_terms(q, [(0, 0), *OF_MASS]), extra.T)
    mass = {
        f"m{i + 1}{j + 1}_{a}{b}": c for (i, j), found in zip(ENTRIES, constant_too[1:].T, strict=True)
        for (a, b), c in zip(OF_MASS, found, strict=True)
    }  # fmt: skip
    laws = {"inertia": mass, "stiffness": springs, "transmission": bend}
    return {kind: {f"{effects[kind].effect}.{effects[kind].form}.{name}.0": x for name, x in law.items()} for kind, law in laws.items()}


def _terms(q: tuple, powers, by: int | None = None) -> np.ndarray:
    """(points, powers) monomials s^i l^j, or their derivatives by one of the angles."""
    if by is None:
        return np.stack([q[0] ** a * q[1] ** b for a, b in powers], 1)
    return np.stack([p[by] * q[by] ** max(p[by] - 1, 0) * q[1 - by] ** p[1 - by] for p in powers], 1)


def _fitted(basis: np.ndarray, values: np.ndarray) -> np.ndarray:
    return np.linalg.lstsq(basis, values, rcond=None)[0]


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


def main(seconds: float = 3.0, seed: int = 3, lever: Literal["fine_map", "map"] = "fine_map") -> None:
    """Prints the tables."""
    simple, full = machine_of("simple", "fl"), machine_of("full", "fl")
    found = differences(simple, full, lever=lever)
    say = sys.stdout.write
    say("| swing, lift, rad | M11, g mm2 | M12 | M22 | K11, N mm/rad | K22 | D11, N mm ms/rad | D22 | swing lever, mm/rad | lift lever |\n")
    say("|---|---|---|---|---|---|---|---|---|---|\n")
    for q in [*((a, 0.0) for a in GRID[::4]), *((0.0, a) for a in GRID[::4] if a)]:
        m11, m12, m22, k11, k22, d11, d22, swing, lift = reduced(full, q)
        say(f"| {q[0]:.1f}, {q[1]:.1f} | {m11:.3f} | {m12:.3f} | {m22:.3f} | {k11:.3f} | {k22:.3f} | {d11:.4f} | {d22:.4f} | "
            f"{swing:.3f} | {lift:.3f} |\n")  # fmt: skip
    errors = ablate(simple, full, found, seconds=seconds, seed=seed)
    say("\n| simple with | free run, rad2 | 8 ms, rad2 | 8 ms, times lower |\n|---|---|---|---|\n")
    for group, (free, short) in errors.items():
        say(f"| {' + '.join(group) or 'nothing'} | {free:.3g} | {short:.3g} | {errors[()][1] / short:.3g} |\n")


if __name__ == "__main__":
    tyro.cli(main)
