"""The arm of two links in docs/other_machines.md, against the work that its drives do and its dampers take."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from hamr_dynamics.machine import Machine
from hamr_dynamics.machine_kernel import simulate
from hamr_gap.fitting.scales import Scales

PAGE = Path(__file__).parents[2] / "docs" / "other_machines.md"
STEP, N = 1e-3, 4000


def arm() -> Machine:
    """As the page has it."""
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    (imports,) = (b for b in blocks if "COLUMNS = {\"drive\"" in b)
    (links,) = (b for b in blocks if "def two_links" in b)
    scope: dict = {}
    exec(imports + links, scope)
    return scope["two_links"]()


def energy(machine: Machine, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """(n,) J, kinetic by the page's mass matrix and potential by the weights."""
    m11, m12, m22 = np.array([machine.terms(tuple(x), (0.0, 0.0), (0.0, 0.0), (0.0, 0.0)).mass for x in q]).T
    kinetic = 0.5 * (m11 * v[:, 0] ** 2 + 2.0 * m12 * v[:, 0] * v[:, 1] + m22 * v[:, 1] ** 2)
    return kinetic - 38.0 * np.cos(q[:, 0]) - 1.8 * np.cos(q[:, 0] + q[:, 1])


def test_energy_is_what_drives_have_done_and_dampers_have_taken():
    machine = arm()
    t = STEP * np.arange(N)
    drives = np.stack([12.0 * np.sin(3.0 * t), 2.0 * np.sin(7.0 * t)], 1)
    neutral = machine.neutral(Scales(10.0, 0.5, 0.3, 10.0, 4.0))
    q = simulate(machine, drives, neutral[None], step=STEP, substeps=1)[0]
    v = np.gradient(q, STEP, axis=0)
    power = np.sum(drives * v, 1) - 2.0 * v[:, 0] ** 2 - 0.1 * v[:, 1] ** 2
    work = np.concatenate([[0.0], np.cumsum(0.5 * STEP * (power[1:] + power[:-1]))])
    gained = energy(machine, q, v) - energy(machine, q, v)[0]
    assert np.ptp(q, axis=0).min() > 0.5  # far enough for the links to feel each other's motion
    assert gained[10:-10] == pytest.approx(work[10:-10], abs=5e-3 * np.ptp(gained))


def test_its_matrices_are_what_its_forces_change_by():
    machine, h = arm(), 1e-6
    for q, v in np.random.default_rng(0).uniform(-1.0, 1.0, (5, 2, 2)):
        here = machine.terms(tuple(q), tuple(v), tuple(v), (0.0, 0.0))
        for k, matrix in ((0, here.stiffness), (1, here.damping)):
            for j in (0, 1):
                off = [np.array([q, v]), np.array([q, v])]
                off[0][k, j] -= h
                off[1][k, j] += h
                low, high = (np.array(machine.terms(tuple(a), tuple(b), tuple(b), (0.0, 0.0)).force) for a, b in off)
                own = [matrix[0 + j], matrix[1 + j]]
                assert (low - high) / (2.0 * h) == pytest.approx(own, abs=1e-6)
