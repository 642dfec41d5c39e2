"""What follows from a name: HAMR-simple with the effects that `hamr gap` found, beside the residual learned from the same seconds.

    python -m hamr_bringup.flagship --out out/flagship     last two tables of docs/flagship.md

HAMR-full stands in for the robot: a bag of white noise, as an instrumented robot would have given it, is all that either sees. Both
models are then compared with full on a run that nothing has seen, and walking policies trained on each walk on full.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import tyro

from hamr_bags.excitation import excitation
from hamr_bags.reader import load
from hamr_sim_residual.evaluate import errors, simulate
from hamr_sim_residual.residual_plant import residual_plant
from hamr_sim_residual.train import train as train_residual

from .commands.collect import Command as Collect

HORIZONS_MS = (1.0, 8.0, 32.0, 128.0, 300.0)
UNSEEN = 101  # seed of the run that decides


def main(seconds: tuple[float, ...] = (12.0, 3.0), out: Path = Path("out/flagship"), steps: int = 1_000_000, policies: bool = True) -> None:
    """Prints the tables; what an interrupted call has made is used.

    Args:
        seconds: of white noise that the models learn from. out: folder of bags, models and policies. steps: of each policy's training.
        policies: whether any are trained.
    """
    truth = simulate(excitation("noise", seconds=4.0, seed=UNSEEN).voltages)
    rows = {"HAMR-simple": _position(errors("simple", truth, HORIZONS_MS))}
    for s in seconds:
        effects, residual = learned(out / f"{s:g}s", s)
        rows[f"simple + named effects, {s:g} s"] = _position(errors("simple", truth, HORIZONS_MS, effects=effects))
        rows[f"residual, {s:g} s"] = _position(errors(residual_plant(residual), truth, HORIZONS_MS))
    say = sys.stdout.write
    say("| mean squared error of hip angles, rad2 | " + " | ".join(f"{h:g} ms" for h in HORIZONS_MS) + " |\n")
    say("|---" * (len(HORIZONS_MS) + 1) + "|\n")
    for name, row in rows.items():
        say(f"| {name} | " + " | ".join(f"{x:.2g} ({y / x:.0f} x)" for x, y in zip(row, rows["HAMR-simple"], strict=True)) + " |\n")
    if policies:
        say("\n| policy trained on | speed there, BL/s | on HAMR-full | transfer |\n|---|---|---|---|\n")
        for s in seconds:
            for name, found in walked(out / f"{s:g}s", steps).items():
                say(f"| {name}, {s:g} s | {found['home']:.2f} | {found['full']:.2f} | {found['transfer']:.2f} |\n")


def learned(folder: Path, seconds: float) -> tuple[Path, Path]:
    """An effects file and a residual model from one bag of HAMR-full."""
    from hamr_gap.gap import run as gap

    bag, effects, residual = folder / "measured", folder / "gap" / "effects.yaml", folder / "residual.json"
    if not bag.exists():
        Collect(out=bag, backend="full", seconds=seconds, as_measured=True, direct=True).run()
    gap([bag], folder / "gap", backend="simple")
    if not residual.exists():
        train_residual([load(bag)], residual, resume=True)
    return effects, residual


def walked(folder: Path, steps: int) -> dict[str, dict[str, float]]:
    """Speeds of policies trained on both models, there and on HAMR-full, and the ratio of rewards."""
    from hamr_policy.evaluate import evaluate
    from hamr_policy.train import train

    effects, residual = folder / "gap" / "effects.yaml", folder / "residual.json"
    models = {"simple + named effects": ("simple", {"effects": effects}), "residual": ("residual", {"residual": residual})}
    found = {}
    for name, (backend, more) in models.items():
        home = folder / f"walk_{backend}"
        policy = home / "policy.onnx"
        if not policy.exists():
            train("walk", backend, home, steps=steps, resume=True, **more)
        table = evaluate([policy], ("full",), residual=more.get("residual", ""), trained_with=more.get("effects", ""))["rows"]
        by = {(row["run_on"], row["quantity"]): row["mean"] for row in table}
        at = next(on for on, _ in by if on != "full")
        found[name] = {"home": by[at, "speed"], "full": by["full", "speed"], "transfer": by["full", "transfer"]}
    return found


def _position(found) -> np.ndarray:
    return found.mse[:, 0]


if __name__ == "__main__":
    tyro.cli(main)
