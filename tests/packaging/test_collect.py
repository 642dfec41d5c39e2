"""`hamr collect` plays the signal that was asked for, and says which parameters a signal has."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pytest

from hamr_bags.excitation import excitation
from hamr_bags.reader import load

COLLECT = [sys.executable, "-m", "hamr_bringup.cli", "collect", "--direct", "--backend", "simple", "--json"]


def collect(*words: str) -> dict:
    return json.loads(subprocess.run([*COLLECT, *words], capture_output=True, text=True, check=False).stdout)


@pytest.mark.parametrize(
    ("words", "signal"),
    [
        (("--kind", "steps"), {"kind": "steps", "seed": 3}),
        (("--kind", "trot", "--frequency-hz", "60", "--amplitude-volt", "30"), {"kind": "trot", "frequency_hz": 60.0, "amplitude": 30.0}),
    ],
)
def test_the_bag_holds_the_signal(words, signal, tmp_path):
    assert collect("--seconds", "0.04", "--seed", "3", "--out", str(tmp_path / "bag"), *words)["bag"]
    wanted = excitation(seconds=0.04, **signal).voltages[::5]  # 4 kHz
    np.testing.assert_array_equal(load(tmp_path / "bag").voltages, wanted)
    assert np.ptp(wanted, axis=0).min() > 1.0


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--kind", "nois"), "noise, trot, pronk, triangle, steps, mix"),
        (("--kind", "trot", "--band-hz", "40"), "no parameter 'band_hz'"),
        (("--amplitude-volt", "40"), "no parameter 'amplitude'"),
    ],
)
def test_a_signal_that_does_not_fit_is_one_sentence(words, says, tmp_path):
    found = collect("--out", str(tmp_path / "bag"), *words)
    assert found["ok"] is False and says in found["error"]
    assert not (tmp_path / "bag").exists()
