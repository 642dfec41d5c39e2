"""Trains a tanh network k(q, v, V) -> hip torques by Adam: the paper's method, and the same with the simulator itself for surrogate.

First one step ahead, accelerations against those of the smoothed angles; then many: windows of 8 ms are rolled out, the prediction
fed back, and angles, rates and accelerations compared with the measured ones. Physics is one of
    surrogate  the paper: gradients pass a network that was trained to imitate HAMR-simple's step (`surrogate`)
    step       HAMR-simple's own compiled step with its adjoint
    euler      the surrogate under explicit Euler at 0.25 ms, as the paper's figure draws it; it grows on its own, so the network
               learns the integrator's error along: for comparison only
Loss weights, which the paper leaves open: errors of q, v and a each relative to the variable's standard deviation, summed with
weights 1, 1 and 0.1 (accelerations follow the others, and are the noisiest).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from tqdm import tqdm

from hamr_description.names import LEGS
from hamr_description.numbers import value
from hamr_description.rates import SERVO_MS
from hamr_dynamics.leg_step import LegStep

from . import surrogate
from .dataset import Stretch
from .mlp import Mlp
from .network import Network
from .perceptron import TYPE, Adam, Perceptron
from .residual_plant import torque_driven
from .simple import simple_parameters

PHYSICS = ("surrogate", "step", "euler")
HORIZON_MS, BATCH = 8.0, 8  # windows of the paper
ONE_STEP_BATCH = 256
UPDATES = {"one-step": 20_000, "multi-step": 600}
RATES = {"one-step": 5e-3, "multi-step": 3e-4}
WEIGHTS = (1.0, 1.0, 0.1)
EULER_EVERY = 5  # 0.25 ms
SAVE_EVERY = 200


class LegStepFunction(torch.autograd.Function):
    """HAMR-simple's step as a torch operation: state (6, lanes), torque (2, lanes), param -> state."""

    @staticmethod
    def forward(ctx, state, torque, param, step):
        ctx.step, ctx.param = step, param
        ctx.save_for_backward(state, torque)
        return torch.from_numpy(step.step(state.numpy(), torque.numpy(), param)).to(TYPE)

    @staticmethod
    def backward(ctx, grad):
        state, torque = (x.numpy() for x in ctx.saved_tensors)
        of_state, of_torque, _ = ctx.step.pullback(state, torque, ctx.param, grad.numpy())
        return torch.from_numpy(of_state).to(TYPE), torch.from_numpy(of_torque).to(TYPE), None, None


@dataclass(frozen=True, slots=True)
class Data:
    """Samples of all stretches as float32 tensors (legs, n, 2), and where windows may start.

    Attributes:
        q, v, a, drive: rad, rad/ms, rad/ms^2 (of the step that begins there), V.
        starts: samples from which all legs stay clear of their stops for a horizon. clear: samples at which they are.
        scale: largest |q|, |v|, |drive|. spread: standard deviations of q, v, a.
    """

    q: torch.Tensor
    v: torch.Tensor
    a: torch.Tensor
    drive: torch.Tensor
    starts: np.ndarray
    clear: np.ndarray
    scale: tuple[float, float, float]
    spread: tuple[float, float, float]


def collect(parts: Sequence[Stretch], steps: int) -> Data:
    """Data for windows of `steps` steps."""
    arrays, starts, clear, offset = [], [], [], 0
    for part in parts:
        a = np.diff(part.v, axis=1, append=part.v[:, -1:]) / SERVO_MS
        arrays.append((part.q, part.v, a, part.drive))
        good = part.inside.all(axis=0)
        good[[0, -1]] = False
        run = np.concatenate([[0], np.cumsum(good)])
        k = np.arange(1, max(1, len(part) - steps - 1))
        starts.append(offset + k[run[k + steps + 1] - run[k] == steps + 1])
        clear.append(offset + np.flatnonzero(good))
        offset += len(part)
    q, v, a, drive = (np.concatenate(column, axis=1) for column in zip(*arrays, strict=True))
    every = np.concatenate(clear)
    spread = tuple(float(x[:, every].std()) for x in (q, v, a))
    tensors = (torch.tensor(x, dtype=TYPE) for x in (q, v, a, drive))
    return Data(*tensors, np.concatenate(starts), every, tuple(float(np.abs(x[:, every]).max()) for x in (q, v, drive)), spread)


class Trainer:
    """One training run: the network, its physics and its losses."""

    def __init__(self, parts: Sequence[Stretch], law: Mlp, physics: str, seed: int) -> None:
        self.law, self.physics, self.seed = law, physics, seed
        self.steps = round(HORIZON_MS / SERVO_MS)
        self.data = collect(parts, self.steps)
        self.net = Perceptron(law.sizes)
        self.step = LegStep(torque_driven())
        self.f: surrogate.Surrogate | None = None
        p = simple_parameters(LEGS[0])
        self.unit = max(p["torque_per_volt"]) * value("actuator.neutral_voltage")  # network output 1
        gravity = value("robot.gravity")
        self.columns = np.array([self.step.parameters(leg, gravity=gravity) for leg in LEGS])
        self.rear = torch.tensor([[1.0 if leg[0] == "r" else -1.0] for leg in LEGS], dtype=TYPE)

    def rows(self, x: torch.Tensor) -> torch.Tensor:
        """(legs, n, 2) -> (rows, 2 per network): legs one by one, or side by side as the kernel has them (axis, leg)."""
        if self.law.legs == 1:
            return x.reshape(-1, 2)
        return x.permute(1, 2, 0).reshape(-1, 8)

    def torque(self, layers, q, v, drive) -> torch.Tensor:
        """Torques of rows."""
        a, b, c = self.data.scale
        return self.unit * self.net(layers, torch.cat((q / a, v / b, drive / c), dim=1))

    def accelerate(self, q, v, torque) -> torch.Tensor:
        """Accelerations by the surrogate, rows as `rows` gives them."""
        if self.law.legs == 1:
            return self.f(q, v, torque, self.rear.repeat_interleave(len(q) // 4, dim=0))
        legs = [x.view(-1, 2, 4).transpose(1, 2).reshape(-1, 8) for x in (q, v, torque)]  # the surrogate's order: (leg, axis)
        return self.f(*legs, None).view(-1, 4, 2).transpose(1, 2).reshape(-1, 8)

    def one_step(self, weights: torch.Tensor, chosen: np.ndarray) -> torch.Tensor:
        """Mean squared error of accelerations, relative to their variance."""
        d = self.data
        q, v, a, drive = (self.rows(x[:, chosen]) for x in (d.q, d.v, d.a, d.drive))
        torque = self.torque(self.net.split(weights), q, v, drive)
        if self.physics != "step":
            return torch.mean((self.accelerate(q, v, torque) - a) ** 2) / d.spread[2] ** 2
        last = (d.a[:, chosen - 1]).permute(2, 0, 1).reshape(2, -1)
        state = torch.cat([self.lanes(q), self.lanes(v), last])
        new = LegStepFunction.apply(state, self.lanes(torque), self.param(len(chosen)), self.step)
        return torch.mean((new[4:] - self.lanes(a)) ** 2) / d.spread[2] ** 2

    def lanes(self, x: torch.Tensor) -> torch.Tensor:
        """Rows -> (2, lanes), lane = leg * n + window."""
        return x.t() if self.law.legs == 1 else x.view(-1, 2, 4).permute(1, 2, 0).reshape(2, -1)

    def from_lanes(self, x: torch.Tensor) -> torch.Tensor:
        """Inverse of `lanes`."""
        return x.t() if self.law.legs == 1 else x.view(2, 4, -1).permute(2, 0, 1).reshape(-1, 8)

    def param(self, n: int) -> np.ndarray:
        """Leg parameters of lanes."""
        return np.repeat(self.columns, n, axis=0).T

    def multi_step(self, weights: torch.Tensor, chosen: np.ndarray) -> torch.Tensor:
        """Mean squared errors of q, v, a over windows, relative to their variances, weighted."""
        d, every = self.data, EULER_EVERY if self.physics == "euler" else 1
        layers, h = self.net.split(weights), SERVO_MS * every
        q, v = self.rows(d.q[:, chosen]), self.rows(d.v[:, chosen])
        state = torch.cat([self.lanes(q), self.lanes(v), d.a[:, chosen - 1].permute(2, 0, 1).reshape(2, -1)])
        param, total = self.param(len(chosen)), 0.0
        for k in range(0, self.steps, every):
            torque = self.torque(layers, q, v, self.rows(d.drive[:, chosen + k]))
            if self.physics == "step":
                state = LegStepFunction.apply(state, self.lanes(torque), param, self.step)
                q, v, a = (self.from_lanes(x) for x in (state[:2], state[2:4], state[4:]))
            else:
                a = self.accelerate(q, v, torque)
                before, v = v, v + h * a
                q = q + h * (before if self.physics == "euler" else 0.5 * (before + v))
            after = chosen + k + every
            goals = self.rows(d.q[:, after]), self.rows(d.v[:, after]), self.rows(d.a[:, chosen + k])
            for x, goal, spread, weight in zip((q, v, a), goals, d.spread, WEIGHTS, strict=True):
                total = total + weight * torch.mean((x - goal) ** 2) / spread**2
        return total * every / self.steps

    def network(self, weights: np.ndarray) -> Network:
        """The trained network with its scaling folded in, ready for the kernels."""
        layers = [x.numpy().astype(float) for x in self.net.split(torch.from_numpy(weights))]
        per = len(LEGS) if self.law.legs == 4 else 1
        layers[0] = layers[0] / np.repeat(self.data.scale, 2 * per)
        layers[-2], layers[-1] = self.unit * layers[-2], self.unit * layers[-1]
        arrays = {f"{'wb'[i % 2]}{i // 2}": x for i, x in enumerate(layers)}
        arrays["skip"] = np.zeros((self.law.sizes[-1], self.law.sizes[0]))
        return Network(self.law, self.law.join(arrays))


def learn(parts: Sequence[Stretch], law: Mlp, physics: str, seed: int, checkpoint, progress: bool) -> tuple[Network, dict]:
    """Trains a network; (network, figures). An update's random choices depend on seed and count alone: a resumed run is the same."""
    trainer, found, figures = Trainer(parts, law, physics, seed), checkpoint.load() or {}, {}
    phases = [
        ("one-step", trainer.one_step, trainer.data.clear, ONE_STEP_BATCH),
        ("multi-step", trainer.multi_step, trainer.data.starts, BATCH),
    ]
    with tqdm(total=(surrogate.UPDATES if physics != "step" else 0) + sum(UPDATES.values()), disable=not progress, unit="") as bar:
        if physics != "step":
            bar.set_description("surrogate")
            trainer.f = surrogate.learn(law.legs, np.random.default_rng([seed, 0]), bar.update)
            figures["surrogate_error"] = trainer.f.error
        weights = trainer.net.initial(np.random.default_rng([seed, 1]))
        for number, (phase, loss, pool, size) in enumerate(phases):
            bar.set_description(phase)
            if number < int(found.get("phase", 0)):
                bar.update(UPDATES[phase])
                continue
            pace = {"rate": RATES[phase], "updates": UPDATES[phase]}
            adam, found = Adam.of(found, **pace) if found else Adam(weights, **pace), {}
            bar.update(adam.done)
            while adam.done < adam.updates:
                chosen = np.random.default_rng([seed, 2 + number, adam.done]).choice(pool, size)
                figures["loss"] = adam.update(lambda w, i=chosen, f=loss: f(w, i))
                bar.update()
                if adam.done % SAVE_EVERY == 0:
                    checkpoint.save({"phase": np.array(number), **adam.arrays})
                    bar.set_postfix_str(f"loss {figures['loss']:.2g}")
            weights = adam.weights.detach()
    return trainer.network(weights.numpy()), figures
