"""The proof: the same machine re-simulated under data that nothing has used, as given, re-tuned, with the effect and without it again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hamr_dynamics.machine import Machine

from ..answers.found import STATES, Found
from ..data.readings import sensor_noise
from ..data.record import Record
from ..data.si import channel_si
from ..fitting.initial_states import InitialStates
from ..fitting.model import Model
from ..fitting.scales import scales_of
from ..fitting.settled import settled

#: Seconds, and readings at least, after which a re-initialised run is judged, besides the free run.
HORIZONS = ((0.008, 8), (0.05, 50))
WINDOW_S = 0.15  # shown in pictures
SETTLED_S = 0.5  # left out of a record that does not begin at rest


def show(machine: Machine, found: Found, record: Record, *, fresh: bool) -> tuple[dict, dict[str, np.ndarray]]:
    """Gaps on a record in all states.

    Args:
        fresh: whether nothing has seen the record; if not, only its readings of the report role count.

    Returns:
        {"over_floor": {STATE: rms in units of the noise, all channels}, "closed": G, the share of the re-tuned gap's mean square, less
        noise, that the effect takes away; "channels": {channel: {"unit", "noise", STATE: rms, SI}}, "horizons": {"0.008 s": {STATE: ...}},
        "readings": how many}, and arrays for pictures.
    """
    model = _model(machine, found, record)
    rows = np.stack([found.arrays[f"rows.{state}"] for state in STATES])
    used = found.arrays["report"] if not fresh else _settled(model)
    noise = sensor_noise(record) / np.sqrt(model.mean)
    chosen = used[:, None] & np.isfinite(model.target)
    runs, left = {}, {}
    for state, row in zip(STATES, rows, strict=True):
        begun = settled(model, row, noise, found.sensors(state)) if found.simulation["settled"] else model
        runs[state] = found.sensors(state).read(begun.run_rows(row[None])[0], model.reading_step, model.starts)
        left[state] = np.where(chosen, _beside_starts(begun, row, noise, model.target - runs[state]), np.nan)
    over = {state: _rms(x / noise) for state, x in left.items()}
    channels = {}
    for c, channel in enumerate(record.channels):
        factor, unit = channel_si(machine, channel)
        channels[channel] = {"unit": unit, "noise": float(noise[c]) * factor} | {s: _rms(x[:, c]) * factor for s, x in left.items()}
    shown = {
        "readings": int(chosen.sum()), "over_floor": over, "closed": closed(over), "channels": channels,
        "horizons": {f"{h * machine.to_si['T']:.2g} s": _growth(model, found, rows, noise, used, h) for h in _horizons(model)},
    }  # fmt: skip
    return shown, _pictured(machine, model, noise, used, runs)


def _beside_starts(model: Model, row: np.ndarray, noise: np.ndarray, left: np.ndarray) -> np.ndarray:
    """What a run with lane parameters (rows,) leaves, (n, channels), less what other starts of its pieces make of it."""
    initial = InitialStates.about(model, row, noise)
    return initial.beside(left) if initial else left


def closed(over: dict[str, float]) -> float | None:
    """Share of the re-tuned gap that is gone, in mean squares less noise; None where there was none."""
    before, after = (over[state] ** 2 - 1.0 for state in ("retuned", "after"))
    return (before - after) / before if before > 0.05 else None


def _model(machine: Machine, found: Found, record: Record, piece: float = 0.0) -> Model:
    how = found.simulation
    per = record.drives_per_reading
    substeps = max(1, round(how["substeps"] * record.step / how["step"] / per)) * per
    mean = max(1, round(how["mean"] * how["step"] / record.step))
    held = replace(record, held=how["held"])
    return Model(machine, held, substeps, mean, scales_of(machine, held), piece or how["piece"], how["delay"])


def _settled(model: Model) -> np.ndarray:
    """(n,) readings after the machine has forgotten how it started."""
    used = np.ones(len(model.target), bool)
    if not model.record.rest and model.pieces is None:
        used[: int(SETTLED_S / model.machine.to_si["T"] / model.reading_step)] = False
    return used


def _horizons(model: Model) -> list[float]:
    """T after which runs that start anew are judged."""
    return [max(seconds / model.machine.to_si["T"], readings * model.reading_step) for seconds, readings in HORIZONS]


def _growth(model: Model, found: Found, rows: np.ndarray, noise: np.ndarray, used: np.ndarray, horizon: float) -> dict[str, float]:
    """As `over_floor`, of runs over T that start anew from measured motion, at their last readings."""
    bias = found.sensors("after").bias  # the motion is what the sensors read without it
    free_of_bias = replace(model.record, readings=model.record.readings - bias)
    pieced = replace(model, record=free_of_bias, piece=horizon)
    last = np.zeros(len(used), bool)
    last[pieced.pieces.stop - 2] = True  # the very last one's slope reaches into the next piece
    chosen = (last & used)[:, None] & np.isfinite(pieced.target)
    growth = {}
    for state, run in zip(STATES, pieced.run_rows(rows), strict=True):
        left = pieced.target - replace(found.sensors(state), bias=0.0 * bias).read(run, model.reading_step, pieced.starts)
        growth[state] = _rms(np.where(chosen, left, np.nan) / noise)
    return growth


def _pictured(machine: Machine, model: Model, noise: np.ndarray, used: np.ndarray, runs: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Time s, noise and readings SI of all states; `used`; the stretch to show."""
    factor = np.array([channel_si(machine, channel)[0] for channel in model.record.channels])
    step = model.reading_step * machine.to_si["T"]
    length = min(int(WINDOW_S / step), len(used))
    left = np.nan_to_num(np.where(used[:, None], (model.target - runs["retuned"]) / noise, 0.0))
    begin = int(np.argmax(np.convolve(np.sum(left**2, axis=1), np.ones(length), "valid")))  # where the re-tuned model is worst
    found = {"time": np.arange(len(used)) * step, "used": used, "window": np.array([begin, begin + length]), "noise": noise * factor}
    found |= {state: (run * factor).astype(np.float32) for state, run in runs.items()}
    return found | {"target": (model.target * factor).astype(np.float32)}


def _rms(x: np.ndarray) -> float:
    return float(np.sqrt(np.nanmean(x**2)))
