"""`hamr collect` plays the signal that was asked for, and says which parameters a signal has."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hamr_bags.bag import open_bag
from hamr_bags.check import check
from hamr_bags.decode import decode_all
from hamr_bags.excitation import excitation
from hamr_bags.reader import base_pose, load
from hamr_bags.topics import ODOMETRY
from hamr_description.names import Topic

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


def test_on_the_ground_the_pose_is_measured_too(tmp_path):
    gait = ("--environment", "ground", "--kind", "trot", "--frequency-hz", "16", "--seconds", "0.4", "--out")
    collect(*gait, str(tmp_path / "exact"))
    collect(*gait, str(tmp_path / "seen"), "--as-measured")
    truth, seen = base_pose(tmp_path / "exact"), base_pose(tmp_path / "seen")
    assert np.ptp(truth.position, axis=0).max() > 1e-3  # it walks
    assert (seen.position - truth.position).std() == pytest.approx(5e-5, rel=0.2)  # 300 readings: sigma 4 %
    turned = (Rotation.from_quat(truth.quaternion).inv() * Rotation.from_quat(seen.quaternion)).as_rotvec()
    assert turned.std() == pytest.approx(2e-3, rel=0.2)
    assert load(tmp_path / "seen").environment == "ground" and check(tmp_path / "seen").ok
    with open_bag(tmp_path / "seen") as bag:
        twists = [numbers for _, numbers in decode_all(bag.raws(Topic.ODOM)[1], ODOMETRY, ())]
    assert all(not numbers["linear"].any() and (numbers["twist_covariance"][:, 0] == -1).all() for numbers in twists)


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
