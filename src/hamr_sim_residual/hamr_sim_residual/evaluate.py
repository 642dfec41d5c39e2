"""How far plants stray from measured motion: mean squared errors of position, velocity and acceleration against the horizon.

From many points of a held-out run each plant starts in the true state and runs freely under the run's voltages. Windows in which
an actuator reaches its end stop are left out from there on.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hamr_description.numbers import value
from hamr_description.rates import SERVO_MS
from hamr_description.units import rate_to_si
from hamr_dynamics.batch import BatchSim
from hamr_dynamics.plant import Plant

from .dataset import CLEAR

HORIZONS_MS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0, 300.0)
QUANTITIES = {"position": "rad", "velocity": "rad/s", "acceleration": "rad/s^2"}
WINDOWS = 150


@dataclass(frozen=True, slots=True)
class Truth:
    """A held-out run of one robot, one sample every 50 us, (n, 8) in canonical joint order.

    Attributes:
        q, qd, qdd: rad, rad/ms, rad/ms^2 of the step that begins at the sample. volts: held to the next sample, V.
        inside: whether the joint's actuator is clear of its end stop.
    """

    q: np.ndarray
    qd: np.ndarray
    qdd: np.ndarray
    volts: np.ndarray
    inside: np.ndarray


def simulate(volts: np.ndarray, plant: str | Plant = "full") -> Truth:
    """A suspended run of a plant from rest under volts (n, 8)."""
    return _truth(BatchSim(plant, 1, environment="suspended").step_voltages(volts[None], record=True), plant)


def simulate_servo(targets: np.ndarray, plant: str | Plant = "full") -> Truth:
    """A suspended run of a plant from rest under the leg law, with targets (periods, 8) rad."""
    sim = BatchSim(plant, 1, environment="suspended")
    periods = [sim.step_targets(target[None], record=True) for target in targets]
    return _truth({name: np.concatenate([p[name] for p in periods], axis=1) for name in ("q", "qd", "volts")}, plant)


def _truth(run: Mapping[str, np.ndarray], plant: str | Plant) -> Truth:
    q, qd, volts = (run[name][0] for name in ("q", "qd", "volts"))
    look = BatchSim(plant, len(q), environment="suspended")
    look.set_state(q=q, qd=qd)
    inside = np.abs(look.observe(volts)["tip"]) < CLEAR * value("actuator.stop")
    return Truth(q[:-1], qd[:-1], np.diff(qd, axis=0) / SERVO_MS, volts[:-1], inside[:-1])


@dataclass(frozen=True, slots=True)
class Errors:
    """Mean squared errors (horizons, 3) in SI: position rad^2, velocity rad^2/s^2, acceleration rad^2/s^4; NaN where no window is left.

    Attributes:
        horizons: ms. samples: joint-windows behind each row. finite: whether no window diverged.
    """

    horizons: tuple[float, ...]
    mse: np.ndarray
    samples: np.ndarray
    finite: bool


def errors(plant: str | Plant, truth: Truth, horizons: tuple[float, ...] = HORIZONS_MS, *, effects: str | Path = "") -> Errors:
    """Errors of a plant in free runs from WINDOWS points of a run, evenly spread; horizons that do not fit the run are left out.

    Args:
        effects: file of what is added to the plant.
    """
    horizons = tuple(h for h in horizons if h / SERVO_MS + 1 < len(truth.q) // 2)
    ahead = np.array([round(h / SERVO_MS) for h in horizons])
    last = int(ahead.max())
    starts = np.unique(np.linspace(1, len(truth.q) - last - 2, WINDOWS).astype(int))
    sim = BatchSim(plant, len(starts), environment="suspended", effects=effects or None)
    sim.set_state(q=truth.q[starts], qd=truth.qd[starts])
    run = sim.step_voltages(np.stack([truth.volts[s : s + last + 2] for s in starts]), record=True)
    inside = truth.inside.reshape(len(truth.q), 4, 2).all(axis=2).repeat(2, axis=1)
    touched = np.concatenate([np.zeros((1, 8)), np.cumsum(~inside, axis=0)])
    mse, samples = [], []
    for k in ahead:
        clear = touched[starts + k + 2] == touched[starts]
        now = starts + k
        difference = [
            run["q"][:, k] - truth.q[now],
            rate_to_si(run["qd"][:, k] - truth.qd[now]),
            rate_to_si(rate_to_si((run["qd"][:, k + 1] - run["qd"][:, k]) / SERVO_MS - truth.qdd[now])),
        ]
        samples.append(int(clear.sum()))
        mse.append([float(np.mean(d[clear] ** 2)) if clear.any() else float("nan") for d in difference])
    return Errors(horizons, np.array(mse), np.array(samples), bool(sim.finite.all()))


def table(plants: Mapping[str, str | Plant], runs: Mapping[str, Truth], horizons: tuple[float, ...] = HORIZONS_MS) -> list[dict]:
    """Rows {run, plant, quantity, unit, horizon_ms, mse, samples, finite} of every plant on every run."""
    rows = []
    for run, truth in runs.items():
        for name, plant in plants.items():
            found = errors(plant, truth, horizons)
            rows += [
                {
                    "run": run, "plant": name, "quantity": quantity, "unit": f"({unit})^2", "horizon_ms": h, "mse": float(found.mse[i, j]),
                    "samples": int(found.samples[i]), "finite": found.finite,
                }
                for i, h in enumerate(found.horizons) for j, (quantity, unit) in enumerate(QUANTITIES.items())
            ]  # fmt: skip
    return rows


def gains(rows: list[dict], over: str) -> list[dict]:
    """Rows of `table` with `gain`: how many times lower the error is than that of plant `over`, same run, quantity and horizon."""

    def key(row: dict) -> tuple:
        return row["run"], row["quantity"], row["horizon_ms"]

    base = {key(row): row["mse"] for row in rows if row["plant"] == over}
    return [row | {"over": over, "gain": base[key(row)] / row["mse"]} for row in rows if row["plant"] != over]


def figure(rows: list[dict], path: str | Path) -> Path:
    """The paper's figure from rows of `table`: one column a run, one row a quantity, error against horizon."""
    from matplotlib.figure import Figure

    runs, plants = list(dict.fromkeys(r["run"] for r in rows)), list(dict.fromkeys(r["plant"] for r in rows))
    canvas = Figure(figsize=(3.2 * len(runs) + 1.5, 7.5), layout="constrained")
    axes = canvas.subplots(len(QUANTITIES), len(runs), sharex=True, sharey="row", squeeze=False)
    for j, run in enumerate(runs):
        for i, (quantity, unit) in enumerate(QUANTITIES.items()):
            for plant in plants:
                line = [(r["horizon_ms"], r["mse"]) for r in rows if (r["run"], r["quantity"], r["plant"]) == (run, quantity, plant)]
                axes[i, j].loglog(*zip(*line, strict=True), marker=".", label=plant)
            axes[i, j].grid(alpha=0.3)
            if j == 0:
                axes[i, j].set_ylabel(f"MSE of {quantity}, ({unit})$^2$")
        axes[0, j].set_title(run)
        axes[-1, j].set_xlabel("horizon, ms")
    canvas.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=len(plants))
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    canvas.savefig(path, dpi=110)
    return path
