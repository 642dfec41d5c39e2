"""`hamr gap` on two machines of others, as measured: a positioning axis that lacks dry friction, an oscillator with a spring too straight.

EMPS: Janot, Gautier, Brunot 2019; Silverbox: Wigren, Schoukens 2013; both free benchmark data of nonlinearbenchmark.org, not part of
this repository. The folder with emps/ and silverbox/ is the first argument, or ../shared/data/real; a second one is a folder for a
picture. docs/other_machines.md tells more.
"""

import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.io import loadmat

from hamr_dynamics.machine import linear_machine
from hamr_gap.data.columns import record_of
from hamr_gap.fitting.model import Model
from hamr_gap.fitting.scales import scales_of
from hamr_gap.plants import load, run
from hamr_gap.study import stored

DATA = Path(__file__).resolve().parents[2] / "shared" / "data" / "real"
ARROW = 40_000  # rows of Silverbox that grow in amplitude; multisines follow, 8692 rows each


def cart():
    """Mass and viscous friction as a data sheet might say, both some 20 % off; the drive is the motor's force."""
    units = {"F": "N", "Q": "m", "T": "s", "U": "N"}
    return linear_machine("emps", inertia=110.0, damping=160.0, joint="cart", units=units)


def oscillator():
    """A resonance somewhere near 70 Hz, damped a little, of one volt per volt."""
    units, w = {"F": "V", "Q": "V", "T": "s", "U": "V"}, 2.0 * np.pi * 70.0
    return linear_machine("silverbox", inertia=w**-2, damping=0.1 / w, stiffness=1.0, joint="output", units=units)


def tables(out: Path, data: Path = DATA) -> dict[str, Path]:
    """The published files as tables of named columns."""
    for name in ("DATA_EMPS", "DATA_EMPS_PULSES"):
        found = loadmat(data / "emps" / f"{name}.mat")
        time, volts, position, newtons = (found[key].ravel() for key in ("t", "vir", "qm", "gtau"))
        np.savez(out / f"{name}.npz", **{"time [s]": time, "drive [N]": volts * newtons, "cart [m]": position})
    volts = np.loadtxt(data / "silverbox" / "SNLS80mV.csv", delimiter=",", skiprows=1, usecols=(0, 1))
    first, later = (ARROW + 500 + k * 8692 for k in (0, 1))
    parts = {"multisine": slice(first, first + 8192), "another": slice(later, later + 8192), "arrow": slice(0, ARROW)}
    for name, part in parts.items():
        time = np.arange(len(volts[part])) * 2**14 / 1e7
        np.savez(out / f"{name}.npz", **{"time [s]": time, "drive [V]": volts[part, 0], "output [V]": volts[part, 1]})
    return {path.stem: path for path in out.glob("*.npz")}


def left(name: str, table: Path, measured: Path, out: Path, seconds: float = 0.0) -> dict[str, np.ndarray]:
    """What each state of the model leaves of a table, in runs that start anew after some seconds."""
    machine, columns = load(f"{__file__}:{name}")
    found = stored(machine, record_of(machine, measured, columns), out)
    record = replace(record_of(machine, table, columns), held=found.simulation["held"])
    model = Model(machine, record, found.simulation["substeps"], 1, scales_of(machine, record), seconds, found.simulation["delay"])
    settled = np.arange(len(record)) * record.step > (0.0 if seconds else 0.5)
    runs = {state: model.run_rows(found.arrays[f"rows.{state}"][None])[0] for state in ("retuned", "after")}
    read = {state: found.sensors(state).read(y, record.step, model.starts) for state, y in runs.items()}
    return {state: (model.target - y)[settled, 0] for state, y in read.items()} | {"measured": model.target[settled, 0]}


def rms(x: np.ndarray) -> float:
    return 1e3 * float(np.sqrt(np.nanmean(x**2)))


def study(name: str, measured: Path, holdout: dict[Path, tuple[str, float, tuple[float, float]]], out: Path) -> list[dict[str, np.ndarray]]:
    """Finds, and prints what each hold-out table says: its words, seconds of a run, and the figures of a fit by hand."""
    result = run(f"{__file__}:{name}", [measured], out, holdout=list(holdout))
    first = result["set"][0] if result["set"] else {"effects": [], "probability": 0.0, "forms": {}}
    print(f"{name}: {result['verdict']}; first answer, {first['probability']:.2f}:")
    for effect in first["effects"]:
        print(f"  {effect['effect']} ({effect['form']})")
        for key, p in effect["parameters"].items():
            print(f"    {key} {p['value']:.4g} ({p['low']:.4g} to {p['high']:.4g}) {p['unit']}")
    print("  forms leave of the gap: " + ", ".join(f"{form} {100 * share:.1f} %" for form, share in first["forms"].items()))
    shown = []
    for table, (words, seconds, (before, after)) in holdout.items():
        shown.append(left(name, table, measured, out, seconds))
        print(f"  {words}: {rms(shown[-1]['retuned']):.2f} -> {rms(shown[-1]['after']):.2f} (by hand {before:.2f} -> {after:.2f})")
    return shown


def draw(shown: dict[str, dict[str, np.ndarray]], step: dict[str, float], unit: dict[str, str], path: Path) -> None:
    """Measured signal and what is left of it, before and after."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(2, len(shown), figsize=(10, 4.6), sharex="col", layout="constrained")
    for (name, x), (above, below) in zip(shown.items(), axes.T, strict=True):
        time = np.arange(len(x["measured"])) * step[name]
        above.plot(time, 1e3 * x["measured"], color="0.25", lw=0.5)
        above.set(title=name, ylabel=f"measured, {unit[name]}")
        for state, colour, words in (("retuned", "tab:orange", "re-tuned"), ("after", "tab:blue", "with the effect")):
            below.plot(time, 1e3 * x[state], color=colour, lw=0.5, label=f"{words}: {rms(x[state]):.2f} {unit[name]} rms")
        below.set(xlabel="time, s", ylabel=f"left, {unit[name]}")
        below.legend(loc="upper left", fontsize=8)
    figure.savefig(path, dpi=80)


def main(data: Path = DATA, pictures: Path | None = None) -> None:
    if not (data / "emps").is_dir() or not (data / "silverbox").is_dir():
        print(f"There are no measured data at {data}: get EMPS and Silverbox from nonlinearbenchmark.org and name their folder.")
        return
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        table = tables(out, data)
        axis = study("cart", table["DATA_EMPS"], {table["DATA_EMPS_PULSES"]: ("other record, 1 s runs, mm", 1.0, (5.59, 2.01))}, out / "a")
        multisine = {table["another"]: ("another multisine, mV", 0.0, (8.21, 0.91))}
        arrow = {table["arrow"]: ("growing amplitude, mV", 0.0, (14.44, 0.96))}
        box = study("oscillator", table["multisine"], multisine | arrow, out / "b")
        if pictures:
            shown = {"EMPS, another record": axis[0], "Silverbox, growing amplitude": box[1]}
            steps, units = dict(zip(shown, (1e-3, 2**14 / 1e7), strict=True)), dict(zip(shown, ("mm", "mV"), strict=True))
            pictures.mkdir(parents=True, exist_ok=True)
            draw(shown, steps, units, pictures / "gap_other_machines.png")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
