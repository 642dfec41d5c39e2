"""How a model is re-tuned: free runs where they stay near what was measured, short ones where they do not."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import butter, sosfilt

from hamr_dynamics.machine import linear_machine
from hamr_gap.analyse import analyse
from hamr_gap.record import Record

SLIDE = linear_machine("slide", inertia=1.0, stiffness=20.0, damping=6.0, joint="slide")


def sticking(friction: float) -> Record:
    """80 s of a slide on a spring under slow noise, with N of dry friction that stops it exactly; nobody says where it began."""
    step, fine, n, q, v = 0.01, 20, 8000, 0.2, 0.0
    random = np.random.default_rng(1)
    drive = sosfilt(butter(3, 0.7, fs=1.0 / step, output="sos"), random.standard_normal(n))
    drive, seen, h = 6.0 * drive / drive.std(), np.empty(n), step / fine
    for i, u in enumerate(drive):
        seen[i] = q
        for _ in range(fine):
            v += h * (u - 20.0 * q - 6.0 * v)
            v = np.sign(v) * max(abs(v) - h * friction, 0.0)
            q += h * v
    read = seen + random.normal(0.0, 1e-3 * np.ptp(seen), n)
    return Record(drive[:, None], read[:, None], step, ("slide",), held=True, rest=False)


@pytest.mark.parametrize(("friction", "astray"), [(2.0, False), (4.0, True)])
def test_free_runs_that_go_astray_give_way_to_short_ones(friction, astray):
    """A slide that forgets its start, until it sticks where the model lets it return; either way friction and its size are found."""
    verdict = (found := analyse(SLIDE, sticking(friction))).verdict
    assert bool(found.prepared.weighed.model.starts) == astray
    assert verdict.verdict == "named"
    (effect,) = verdict.set[0].effects
    assert effect.effect == "coulomb_friction"
    assert effect.parameters["level"]["slide"].value == pytest.approx(friction, rel=0.02)
