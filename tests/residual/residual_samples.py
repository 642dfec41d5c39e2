"""What the residual tests share: recordings of the suspended HAMR-full, and networks with random weights."""

from __future__ import annotations

from functools import cache

import numpy as np

from hamr_bags.as_measured import strokes
from hamr_bags.excitation import excitation
from hamr_bags.recording import Recording
from hamr_description.names import Topic
from hamr_description.rates import SERVO_HZ
from hamr_description.units import length_to_si
from hamr_dynamics.batch import BatchSim
from hamr_sim_residual.evaluate import Truth, simulate
from hamr_sim_residual.network import Network


@cache
def noise_run(seed: int, seconds: float, std: float = 64.0) -> Truth:
    """White noise on HAMR-full."""
    return simulate(excitation("noise", seed=seed, seconds=seconds, std=std).voltages)


def recording(truth: Truth, *, noise: float = 0.0, every: int = 1, **extra) -> Recording:
    """A run as a bag would give it: encoder noise as a share of the stroke, every n-th sample."""
    random = np.random.default_rng(1)
    look = BatchSim("full", len(truth.q), environment="suspended")
    look.set_state(q=truth.q, qd=truth.qd)
    joints, tips = (noise * strokes()[topic] for topic in (Topic.SERVO_JOINTS, Topic.SERVO_ACTUATORS))
    angles = truth.q + joints * random.standard_normal(truth.q.shape)
    deflections = length_to_si(look.observe(truth.volts)["tip"]) + tips * random.standard_normal(truth.q.shape)
    keep = slice(None, None, every)
    return Recording(
        time=np.arange(len(truth.q))[keep] / SERVO_HZ, voltages=truth.volts[keep], angles=angles[keep], deflections=deflections[keep],
        environment="suspended", sample_hz=SERVO_HZ / every, **extra,
    )  # fmt: skip


def random_network(law, seed: int = 0, torque: float = 0.1) -> Network:
    """An Mlp with random weights: hidden signals of unit size over joint ranges, outputs of about `torque` N mm."""
    random = np.random.default_rng(seed)
    inputs = np.repeat([0.5, 0.2, 100.0], 2 * law.legs)
    arrays = {name: random.normal(0.0, shape[-1] ** -0.5, shape) for name, shape in law.shapes()}
    last = len(law.hidden)
    arrays["w0"] /= inputs
    for name in (f"w{last}", f"b{last}"):
        arrays[name] *= torque
    arrays["skip"] *= torque / inputs
    return Network(law, law.join(arrays))
