"""`hamr reproduce`: the paper's figures (SEED), measured anew with the models that ship, and whether they agree.

A figure with a spread agrees if the one measured lies within the paper's standard deviation; any other, if what it claims holds here.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from tqdm import tqdm

from hamr_bags.excitation import excitation
from hamr_bags.reader import load
from hamr_description.errors import ConfigError
from hamr_dynamics.plant import Plant
from hamr_policy.evaluate import evaluate, references
from hamr_sim_residual import evaluate as against_truth
from hamr_sim_residual import model_file
from hamr_sim_residual.residual_plant import residual_plant
from hamr_sim_residual.train import train

from .bench import steps
from .direct import direct
from .graph import Run
from .shipped import POLICY, RESIDUAL, TURN_POLICY

GAIN = 100.0  # "orders of magnitude lower", in the words of the paper: two
TRANSFER = 0.9  # "minimal loss": no more than a tenth of the reward
SECONDS, RATIO, SIMPLE_RATIO = 12.0, 47.0, 200.0  # figures of the paper
HORIZONS_MS = (0.25, 8.0, 300.0)  # in the table; the picture has more
SEED, NOISE_S, TROT_S = 1001, 3.0, 1.0  # of runs that no training saw


def reproduce(figures: Iterable[str] = (), *, out: Path | None = None) -> dict:
    """Measures figures of the paper, all of FIGURES if none is given.

    Args:
        figures: keys of FIGURES. out: folder for the picture of `residual`; none if not given.

    Returns:
        rows: [{figure, name, value, unit, paper, agrees, note}], paper as text; agrees: whether, or None where the paper says nothing.

    Raises:
        ConfigError: there is no such figure.
    """
    figures = tuple(figures) or tuple(FIGURES)
    for figure in figures:
        if figure not in FIGURES:
            raise ConfigError(f"There is no figure '{figure}': choose from {', '.join(FIGURES)}.")
    rows = []
    for figure in figures:
        sys.stderr.write(f"== {figure}: {FIGURES[figure].__doc__.splitlines()[0]}\n")
        rows += [{"figure": figure, **row} for row in FIGURES[figure](out)]
    return {"rows": rows}


def _row(name: str, value: float, unit: str, paper: str = "", agrees: bool | None = None, note: str = "") -> dict:
    return {"name": name, "value": value, "unit": unit, "paper": paper, "agrees": agrees, "note": note}


def data(out: Path | None) -> Iterator[dict]:
    """12 s of passive white noise, collected and learned from anew."""
    signal = excitation("noise", seconds=SECONDS)
    with TemporaryDirectory() as folder:
        bag, model = Path(folder, "noise"), Path(folder, "residual.json")
        direct(Run(environment="suspended", excitation=signal.parameters, bag=str(bag), seconds=SECONDS))
        recording = load(bag)
        train([recording], model)
        seconds = len(recording) / recording.sample_hz
        yield _row("data that the residual is learned from", seconds, "s", f"{SECONDS:g}", seconds <= SECONDS)
        anew, shipped = (model_file.load(path).network.values for path in (model, RESIDUAL))
        note = f"weights {'equal' if np.array_equal(anew, shipped) else 'do not equal'} the shipped ones to the bit"
        for row in _gains({"learned anew": residual_plant(model)}, {"noise": _noise()}):
            yield _gain_row(row) | {"note": note}


def residual(out: Path | None) -> Iterator[dict]:
    """Fig. 5b: error of the shipped residual against the horizon, on runs that no training saw."""
    plants = {"residual": residual_plant(RESIDUAL), "published lumped fit": "simple_published"}
    trot = excitation("trot", seconds=TROT_S, frequency_hz=60.0, amplitude=40.0)
    runs = {"noise": _noise(), "trot": against_truth.simulate(trot.voltages)}
    if out:
        sys.stderr.write(f"{out / 'residual.png'}\n")
        against_truth.figure(against_truth.table({"HAMR-simple": "simple", **plants}, runs), out / "residual.png")
    for row in _gains(plants, runs):
        yield _gain_row(row) if row["plant"] == "residual" else _row(_gain_name(row), row["gain"], "x lower", note="a baseline")


def _noise() -> against_truth.Truth:
    return against_truth.simulate(excitation("noise", seed=SEED, seconds=NOISE_S).voltages)


def _gains(plants: dict[str, str | Plant], runs: dict[str, against_truth.Truth]) -> list[dict]:
    rows = []
    for run in tqdm(runs, desc="compare", unit="run", disable=None):
        rows += against_truth.table({"HAMR-simple": "simple", **plants}, {run: runs[run]}, HORIZONS_MS)
    return [row for row in against_truth.gains(rows, "HAMR-simple") if row["quantity"] != "acceleration"]


def _gain_name(row: dict) -> str:
    return f"{row['plant']}, {row['run']}: error of {row['quantity']} after {row['horizon_ms']:g} ms, against HAMR-simple's"


def _gain_row(row: dict) -> dict:
    return _row(_gain_name(row), row["gain"], "x lower", "orders of magnitude", row["gain"] >= GAIN)


def policies(out: Path | None) -> Iterator[dict]:
    """Figs. 6 and 7 and the speeds in the text: policies trained on the residual, on HAMR-full."""
    rows = evaluate([POLICY, TURN_POLICY], ["full"])["rows"]
    for row in (row for row in rows if row["run_on"] == "full"):
        name = f"{row['direction']}, {row['quantity'].replace('_', ' ')} on HAMR-full"
        match row["quantity"]:
            case "transfer":
                yield _row(f"{name} over training", row["mean"], "1", "minimal loss", row["mean"] >= TRANSFER)
            case "upright":
                yield _row(name, row["mean"], row["unit"])
            case quantity if row["reference"]:
                paper = references()[quantity][row["direction"]]
                off = row["mean"] - paper["mean"]
                note = f"{abs(off) / paper['std']:.1f} standard deviations of the paper {'above' if off > 0 else 'below'}"
                yield _row(name, row["mean"], row["unit"], f"{paper['mean']:g} +- {paper['std']:g}", abs(off) <= paper["std"], note)


def speed(out: Path | None) -> Iterator[dict]:
    """Section I: how much faster than HAMR-full the residual simulator runs."""
    cost = {row["name"].removeprefix("substep, "): row["value"] for row in steps()}
    full, fast = cost["MuJoCo full"], cost["kernel full, float32"]
    network = "kernel residual 2 x 100 whole robot, float32"
    pairs = {
        "residual as shipped, float32": ("kernel residual (shipped), float32", RATIO),
        "residual with the paper's network, whole robot, float32": (network, RATIO),
        "HAMR-simple, float32": ("kernel simple, float32", SIMPLE_RATIO),
    }
    for name, (kernel, paper) in pairs.items():
        yield _row(f"{name}, against loop closures in MuJoCo", full / cost[kernel], "x", f"{paper:g}", full / cost[kernel] >= paper)
    for name, (kernel, paper) in pairs.items():
        ratio, note = fast / cost[kernel], "the paper's ratio belongs to its solver"
        yield _row(f"{name}, against HAMR-full in closed form", ratio, "x", f"{paper:g}", ratio >= paper, note)


FIGURES: dict[str, Callable[[Path | None], Iterator[dict]]] = {f.__name__: f for f in (data, residual, policies, speed)}
