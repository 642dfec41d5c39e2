"""The paper's question, asked here: how good is a residual on runs it has not seen, and how does that depend on seconds of data?"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path

import numpy as np

from hamr_description.rates import TARGET_HZ

from . import evaluate
from .dataset import Measured
from .residual_plant import residual_plant
from .train import train

SECONDS = (0.25, 0.5, 1.0, 2.0, 3.0, 6.0, 12.0)
SERVO_TARGET = 0.35  # rad: random targets of the closed-loop run, 20 degrees, clear of the stops
SERVO_SECONDS = 1.0


def held_out(voltages: Callable[..., np.ndarray]) -> dict[str, evaluate.Truth]:
    """Runs of HAMR-full that no training sees; their amplitudes keep most of them clear of the end stops.

    Args:
        voltages: (kind, **parameters) -> (n, 8) V, as `hamr_bags.excitation.excitation(...).voltages`.
    """
    targets = np.random.default_rng(0).uniform(-SERVO_TARGET, SERVO_TARGET, (round(SERVO_SECONDS * TARGET_HZ), 8))
    return {
        "noise, other seed": evaluate.simulate(voltages("noise", seed=101, seconds=4.0)),
        "noise to 100 Hz": evaluate.simulate(voltages("noise", seed=102, seconds=3.0, band_hz=100.0, std=15.0)),
        "noise of 20 V": evaluate.simulate(voltages("noise", seed=103, seconds=3.0, std=20.0)),
        "trot, 60 Hz": evaluate.simulate(voltages("trot", seconds=1.0, amplitude=40.0)),
        "pronk, 25 Hz": evaluate.simulate(voltages("pronk", seconds=1.0, frequency_hz=25.0, amplitude=80.0)),
        "leg law, random targets": evaluate.simulate_servo(targets),
    }


def head(recording: Measured, seconds: float) -> Measured:
    """The first seconds of a recording, the ramp included."""
    n = round(seconds * recording.sample_hz)
    parts = {f.name: getattr(recording, f.name) for f in fields(recording)}
    return replace(recording, **{name: x[:n] for name, x in parts.items() if isinstance(x, np.ndarray)})


def curve(
    recording: Measured, runs: Mapping[str, evaluate.Truth], folder: str | Path, *, methods: Sequence[str] = ("adjoint", "paper"),
    seconds: Sequence[float] = SECONDS, horizons: tuple[float, ...] = (8.0, 300.0), progress: bool = True,
) -> list[dict]:  # fmt: skip
    """Rows of `evaluate.gains` over HAMR-simple with `method` and `seconds`, for models trained on the head of one recording."""
    rows = []
    for method in methods:
        for s in seconds:
            model = train([head(recording, s)], Path(folder) / f"{method}_{s:g}s.json", method=method, progress=progress)["model"]
            table = evaluate.table({"HAMR-simple": "simple", method: residual_plant(model)}, runs, horizons)
            rows += [row | {"method": method, "seconds": s} for row in evaluate.gains(table, "HAMR-simple")]
    return rows


def curve_figure(rows: Sequence[dict], path: str | Path, *, quantity: str = "position", horizon_ms: float = 8.0) -> Path:
    """Gain over HAMR-simple against seconds of data, one panel a run, from rows of `curve`."""
    from matplotlib.figure import Figure

    chosen = [row for row in rows if row["quantity"] == quantity and row["horizon_ms"] == horizon_ms]
    runs, methods = (list(dict.fromkeys(row[key] for row in chosen)) for key in ("run", "method"))
    canvas = Figure(figsize=(3.0 * len(runs), 3.4), layout="constrained")
    for axes, run in zip(np.atleast_1d(canvas.subplots(1, len(runs), sharey=True)), runs, strict=True):
        for method in methods:
            line = [(row["seconds"], row["gain"]) for row in chosen if (row["run"], row["method"]) == (run, method)]
            axes.loglog(*zip(*line, strict=True), marker=".", label=method)
        axes.set(title=run, xlabel="seconds of data")
        axes.grid(alpha=0.3)
    canvas.axes[0].set_ylabel(f"MSE of HAMR-simple over residual's,\n{quantity} at {horizon_ms:g} ms")
    canvas.axes[0].legend()
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    canvas.savefig(path, dpi=110)
    return path
