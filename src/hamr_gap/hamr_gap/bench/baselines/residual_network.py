"""A small network from the motion to the force that the model lacks: it closes a gap and names nothing."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hamr_dynamics import machine_kernel

from ...fitting.model import Model
from ...naming.blocks import better
from ...naming.hypothesis import judge
from ...naming.prepare import Prepared
from .forces import forces_of
from .result import Path, Step

LAGS = (0, 1, 2, 4, 8)  # readings back at which it sees coordinates, rates and drives
WIDTH = 32  # of its two hidden layers
EPOCHS = 1500
PATIENCE = 200  # epochs without a better held-out error
RATE = 3e-3  # of learning
DECAY = 1e-4
WITHIN = 1.5  # of the largest force that it was trained on


@dataclass(frozen=True)
class Network:
    """Layers (weight, bias) with tanh between; inputs are centred and scaled, outputs scaled and bounded."""

    layers: tuple[tuple[np.ndarray, np.ndarray], ...]
    centre: np.ndarray
    spread: np.ndarray
    unit: np.ndarray
    most: np.ndarray

    def force(self, x: np.ndarray) -> np.ndarray:
        """(..., joints) F of (..., inputs)."""
        x = (x - self.centre) / self.spread
        for weight, bias in self.layers[:-1]:
            x = np.tanh(x @ weight + bias)
        weight, bias = self.layers[-1]
        return np.clip((x @ weight + bias) * self.unit, -self.most, self.most)


def network(prepared: Prepared, *, seed: int = 0) -> Path:
    """The model with a network inside, trained on readings of role `fit`; its level is t over blocks by which it leaves less."""
    forces = forces_of(prepared)
    n = forces.joints
    seen = seen_by(prepared, forces.motion.state[:, : 2 * n])
    mean = prepared.weighed.model.mean
    inputs = seen[mean // 2 :: mean][: len(forces.residual)]
    run = simulated(prepared, train(inputs, forces.residual[:, :n], forces.fits, forces.judges, seed=seed))
    model = prepared.weighed.model
    sensors = prepared.weighed.sensors(prepared.weighed.solve_sensors(run)[0])
    reading = sensors.read(run, model.reading_step, model.starts)
    found = judge(prepared.weighed, prepared.judged, (), replace(prepared.base.fit, sensors=sensors, run=run, reading=reading))
    return Path([Step(better(prepared.base.blocks, found.blocks), found, named=False)], threshold=0.0)


def seen_by(prepared: Prepared, moving: np.ndarray) -> np.ndarray:
    """(n, inputs) of coordinates and rates (n, 2 joints) at every sample: these and the drives, now and some readings back."""
    model = prepared.weighed.model
    now = np.hstack([moving, _drives(model)])
    return np.hstack([np.concatenate([np.repeat(now[:1], lag * model.mean, 0), now[: len(now) - lag * model.mean]]) for lag in LAGS])


def train(inputs: np.ndarray, force: np.ndarray, fits: np.ndarray, judges: np.ndarray, *, seed: int) -> Network:
    """A network from inputs (n, inputs) to forces (n, joints), stopped early by the readings that select."""
    import torch

    torch.manual_seed(seed)
    centre, spread, unit = inputs[fits].mean(0), inputs[fits].std(0) + 1e-12, force[fits].std(0) + 1e-30
    x, y = (torch.tensor(a, dtype=torch.float32) for a in ((inputs - centre) / spread, force / unit))
    sizes = (inputs.shape[1], WIDTH, WIDTH, force.shape[1])
    layers = [torch.nn.Linear(a, b) for a, b in zip(sizes[:-1], sizes[1:], strict=True)]
    for p in layers[-1].parameters():  # to begin as the model does
        torch.nn.init.zeros_(p)
    whole = torch.nn.Sequential(layers[0], torch.nn.Tanh(), layers[1], torch.nn.Tanh(), layers[2])
    optimiser = torch.optim.AdamW(whole.parameters(), lr=RATE, weight_decay=DECAY)
    best, kept, since = np.inf, None, 0
    for _ in range(EPOCHS):
        optimiser.zero_grad()
        torch.mean((whole(x[fits]) - y[fits]) ** 2).backward()
        optimiser.step()
        with torch.no_grad():
            held_out = float(torch.mean((whole(x[judges]) - y[judges]) ** 2))
        since += 1
        if held_out < best:
            best, since = held_out, 0
            kept = tuple((p.weight.detach().numpy().T.astype(float), p.bias.detach().numpy().astype(float)) for p in layers)
        if since > PATIENCE:
            break
    return Network(kept, centre, spread, unit, WITHIN * np.abs(force[fits]).max(0))


def simulated(prepared: Prepared, inside: Network) -> np.ndarray:
    """(n, channels) free run of the re-tuned model with a network's force, which is held for one sample."""
    model, base = prepared.weighed.model, prepared.base.fit
    machine, record, n = model.machine, model.record, len(model.machine.joints)
    rows = model.rows(base.free, base.x)
    push = [machine.parameter_rows.index(f"change.preload.{j}") for j in range(n)]
    preload, slip = rows[0, push].copy(), [machine.state_rows.index(f"slip.{j}") for j in range(n)]
    drives, back = _drives(model), model.mean * np.array(LAGS)
    samples = len(model.target) * model.mean
    moving = np.zeros((samples, 2 * n))
    slips = np.zeros((samples, n))
    state = np.zeros((1, len(machine.state_rows)))
    for s in range(samples):
        moving[s], slips[s] = state[0, : 2 * n], state[0, slip]
        at = np.maximum(s - back, 0)
        rows[0, push] = preload + inside.force(np.hstack([moving[at], drives[at]]).ravel())
        state = machine_kernel.final_states(
            machine, model.drives, rows, step=record.step / model.substeps, steps=model.substeps,
            first=np.array([s * model.substeps]), start=state,
        )  # fmt: skip
    read = np.stack(np.broadcast_arrays(*machine.outputs(tuple(moving[:, :n].T), tuple(slips.T))), 1)[:, model.own]
    return read.reshape(len(model.target), model.mean, -1).mean(1)


def _drives(model: Model) -> np.ndarray:
    """(n, joints) mean drive of each sample."""
    seen = model.drives[: len(model.record) * model.substeps]  # of clocks that are ahead, drives go on beyond the end
    return seen.reshape(len(model.record), model.substeps, -1).mean(1)
