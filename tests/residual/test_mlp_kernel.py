"""The compiled tanh network equals torch, in both scopes, both precisions, and both orders of loops."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
import torch
from residual_samples import random_network

from hamr_dynamics import driver, kernels
from hamr_sim_residual import mlp_kernel
from hamr_sim_residual.mlp import Mlp


def compiled(law: Mlp, robots: int, dtype: str):
    """The law's functions alone, without the physics around them."""
    head = driver.HEADER.format(plant="test", environment="law", dtype=dtype)
    return kernels.load_source(f"law_{dtype}_{robots}", head + law.source(robots))


def by_torch(net, x: np.ndarray) -> np.ndarray:
    """The network built from torch's own layers."""
    arrays, sizes = net.law.split(net.values), net.law.sizes
    layers = []
    for i, (n_in, n_out) in enumerate(pairwise(sizes)):
        linear = torch.nn.Linear(n_in, n_out, dtype=torch.float64)
        linear.weight.data, linear.bias.data = torch.tensor(arrays[f"w{i}"]), torch.tensor(arrays[f"b{i}"])
        layers += [linear, torch.nn.Tanh()]
    with torch.no_grad():
        return (torch.nn.Sequential(*layers[:-1])(torch.tensor(x)) + torch.tensor(x @ arrays["skip"].T)).numpy()


@pytest.mark.parametrize("law", [Mlp("leg", (30, 21)), Mlp("robot", (10,))], ids=str)
@pytest.mark.parametrize(("dtype", "robots", "tolerance"), [("float64", 16, 1e-12), ("float64", 1, 1e-12), ("float32", 32, 1e-6)])
def test_kernel_equals_torch(law, dtype, robots, tolerance):
    net, random, legs = random_network(law), np.random.default_rng(3), 4 * robots
    state = (random.uniform(-1, 1, (8, legs)) * np.repeat([0.5, 0.2, 1, 1], 2)[:, None]).astype(dtype)
    drive, torque = random.uniform(-100, 100, (2, legs)).astype(dtype), np.empty(2 * legs, dtype)
    compiled(law, robots, dtype).network(state.ravel(), drive.ravel(), net.weights(dtype), np.empty(net.scratch(robots), dtype), torque)
    x = np.concatenate([state[:4], drive]).astype(float).reshape(law.sizes[0], -1).T
    expected = by_torch(net, x)
    np.testing.assert_allclose(torque.reshape(law.sizes[-1], -1).T, expected, rtol=0, atol=tolerance * np.abs(expected).max())
    np.testing.assert_allclose(law.torque(x, net.values), expected, rtol=0, atol=1e-13)


@pytest.mark.parametrize(("dtype", "tolerance"), [("float64", 5e-15), ("float32", 3e-7)])
def test_tanh_is_as_good_as_stated(dtype, tolerance):
    tanh = compiled(Mlp("leg", (10,)), 1, dtype).tanh
    points = np.concatenate([np.linspace(-25, 25, 4001), np.geomspace(1e-12, 1, 200), [0.0, 700.0, -1e30]]).astype(dtype)
    assert max(abs(float(tanh(x)) - math.tanh(float(x))) for x in points) < tolerance


def test_scratch_covers_every_tile():
    for sizes in ((6, 100, 100, 2), (24, 30, 8), (6, 3, 2)):
        widest = max(mlp_kernel.padded(n) for n in sizes[1:])
        assert mlp_kernel.scratch(sizes) == mlp_kernel.TILE * (mlp_kernel.padded(sizes[0]) + 2 * widest)
