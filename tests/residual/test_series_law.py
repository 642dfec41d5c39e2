"""The series law: compiled and plain forms agree, its structure holds, left and right are mirror images, and it cannot diverge."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hamr_description.names import JOINTS, LEGS, drive_sign, joint_signs
from hamr_description.numbers import value
from hamr_dynamics.batch import BatchSim
from hamr_sim_residual.fit_series import limits, prior
from hamr_sim_residual.network import Network
from hamr_sim_residual.residual_plant import torque_driven
from hamr_sim_residual.series import LIMITS, Series

LAW = Series(3)


def network(seed: int, size: float = 1.0) -> Network:
    """The prior's mean plus random nonlinearities of `size` prior deviations."""
    known, random = prior(LAW), np.random.default_rng(seed)
    return Network(LAW, np.concatenate([limits(), known.mean + size * known.deviation * random.standard_normal(len(known.mean))]))


def states(seed: int, n: int):
    random = np.random.default_rng(seed)
    return (random.uniform(-x, x, (n, 2)) for x in (0.45, 0.3, 0.5, 112.5))


def test_compiled_law_equals_its_definition():
    net, n = network(0), 16
    q, v, _, drive = states(1, 4 * n)
    sim = BatchSim(torque_driven(net), n, environment="suspended")
    signs = np.array([joint_signs(leg) for leg in LEGS])
    sim.set_state(q=(q.reshape(n, 4, 2) * signs).reshape(n, 8), qd=(v.reshape(n, 4, 2) * signs).reshape(n, 8))
    side = np.array([drive_sign(leg) for leg in LEGS])[:, None]
    volts = value("actuator.neutral_voltage") + (drive.reshape(n, 4, 2) * side).reshape(n, 8)
    torque = (sim.observe(volts)["torque"].reshape(n, 4, 2) * signs).reshape(-1, 2)
    plain = np.array(LAW.torque(q.T, v.T, np.zeros_like(q.T), drive.T, net.values)).T
    np.testing.assert_allclose(torque, plain, rtol=0, atol=1e-14)


def test_design_matrix_times_weights_is_the_torque():
    net = network(2)
    q, v, a, drive = states(3, 50)
    design = LAW.design(q, v, a, drive, net.values[: len(LIMITS)])
    plain = np.array(LAW.torque(q.T, v.T, a.T, drive.T, net.values)).T
    np.testing.assert_allclose(design @ net.values[len(LIMITS) :].reshape(2, -1).T, plain, rtol=0, atol=1e-13)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6), share=st.floats(-1, 2))
def test_affine_in_the_drive_voltages(seed, share):
    net = network(seed)
    q, v, a, drive = (x.T for x in states(seed, 3))
    at = [np.array(LAW.torque(q, v, a, s * drive, net.values)) for s in (0.0, 1.0, share)]
    np.testing.assert_allclose(at[2], at[0] + share * (at[1] - at[0]), rtol=0, atol=1e-12)


def test_right_legs_mirror_left_ones():
    sim = BatchSim(torque_driven(network(4)), 1, environment="suspended", gravity=0.0, block=16)
    random = np.random.default_rng(5)
    angle = {axis: random.uniform(-0.3, 0.3) for axis in ("swing", "lift")}
    volt = {axis: random.uniform(-80, 80, 200) for axis in ("swing", "lift")}
    q, volts = np.zeros((1, 8)), np.zeros((1, 200, 8))
    for i, joint in enumerate(JOINTS):
        leg, axis = joint.split("_")
        q[0, i] = joint_signs(leg)[axis == "lift"] * angle[axis]
        volts[0, :, i] = value("actuator.neutral_voltage") + drive_sign(leg) * volt[axis]
    sim.set_state(q=q)
    sim.step_voltages(volts)
    for front_back in "fr":
        left, right = (sim.q[0, [JOINTS.index(f"{front_back}{side}_{axis}") for axis in ("swing", "lift")]] for side in "lr")
        signs = np.array(joint_signs(front_back + "l")) * joint_signs(front_back + "r")
        np.testing.assert_allclose(left, signs * right, rtol=0, atol=1e-14)
        assert np.abs(left).max() > 0.01


@pytest.mark.parametrize("hertz", [10, 60, 200])
def test_even_a_wild_law_stays_finite_and_bounded(hertz):
    sim = BatchSim(torque_driven(network(6, size=10.0)), 16, environment="suspended")
    wave = np.sign(np.sin(2 * np.pi * hertz * np.arange(6000) / 20_000))
    phase = np.random.default_rng(7).choice([-1, 1], (16, 1, 8))
    sim.step_voltages(value("actuator.neutral_voltage") * (1 + phase * wave[None, :, None]))
    assert sim.finite.all()
    assert np.abs(sim.q).max() < 3.0
