"""Offline training of a residual from suspended recordings, measured channels alone.

Methods: `adjoint`, the better one, with derivatives of the simulator's own step: a series law (`fit_series`) or, for comparison, a
tanh network (`fit_mlp`). `paper`: the published method, a tanh network trained through a surrogate of the physics (`fit_mlp`,
`surrogate`); `paper-euler` the same under explicit Euler at 0.25 ms, for comparison only.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np
from tqdm import tqdm

from hamr_description.errors import ConfigError, ModelError
from hamr_description.rates import SERVO_HZ, SERVO_MS
from hamr_dynamics.leg_step import LANES, LegStep

from . import fit_series, model_file
from .dataset import Measured, Stretch, digest, stretches, windows
from .mlp import SCOPES, Mlp
from .network import Law, Network
from .residual_plant import torque_driven
from .series import Series

METHODS = {"adjoint": "series:6", "paper": "leg", "paper-euler": "leg"}  # and the architecture that each takes by default
PHYSICS = {"adjoint": "step", "paper": "surrogate", "paper-euler": "euler"}  # of `fit_mlp`
DEGREES = range(1, 10)
ARCHITECTURES = "adjoint takes series:1 to series:9; every method takes leg or robot, for 2 x 100 tanh, or layers as in leg:32x32"
BAR = "{desc}: {percentage:3.0f} % |{bar}| {elapsed} {postfix}"
HORIZON_MS = 32.0  # of a window: long against a leg's period of 9 ms, so that the unknown initial rates cost little information


def train(
    recordings: Sequence[Measured], out: str | Path, *, method: str = "adjoint", architecture: str = "", seed: int = 0,
    resume: bool = False, progress: bool = True,
) -> dict:  # fmt: skip
    """Learns a residual and writes its model file.

    Args:
        recordings: what `hamr_bags.reader.load` gives of suspended runs.
        out: model file to write; a checkpoint lies beside it while training runs.
        method: one of METHODS.
        architecture: by default series:6 for adjoint and leg for the others. adjoint takes series:1 to series:9; every method takes leg or
            robot, for 2 x 100 tanh, or layers as in leg:32x32.
        seed: of everything random; the adjoint method has nothing random.
        resume: go on from the checkpoint of an interrupted call with the same arguments; the result is the same to the bit.
        progress: bar on standard error.

    Returns:
        JSON-able summary; the same as the model file's `training`, with the path.

    Raises:
        ConfigError for an unknown method or architecture, BagError for recordings that do not fit, ModelError for a checkpoint
        of other arguments.
    """
    if method not in METHODS:
        raise ConfigError(f"Unknown training method '{method}': choose one of {', '.join(METHODS)}.")
    architecture = architecture or METHODS[method]
    law = _law(method, architecture)
    parts = [part for recording in recordings for part in stretches(recording)]
    about = {
        "method": method, "architecture": architecture, "seed": seed, "data": digest(recordings),
        "seconds": round(sum(len(part) for part in parts) / SERVO_HZ, 6), "versions": versions(law),
    }  # fmt: skip
    checkpoint = Checkpoint(Path(out), about, resume)
    if law.kind == Series.kind:
        network, figures = _series(parts, law, checkpoint, progress)
    else:
        from .fit_mlp import learn  # torch takes seconds to import

        network, figures = learn(parts, law, PHYSICS[method], seed, checkpoint, progress)
    about |= figures
    path = model_file.save(model_file.Model(network, about), out)
    checkpoint.remove()
    return {"model": str(path), **about}


def _law(method: str, architecture: str) -> Law:
    kind, _, size = architecture.partition(":")
    if method == "adjoint" and kind == Series.kind and size in map(str, DEGREES):
        return Series(int(size))
    hidden = [n for n in size.split("x") if n.isdigit() and 0 < int(n) <= 1000]
    if kind in SCOPES and "x".join(hidden) == size:
        return Mlp(kind, tuple(map(int, hidden)) or (100, 100))
    raise ConfigError(f"Architecture '{architecture}' does not fit method '{method}': {ARCHITECTURES}.")


def _series(parts: list[Stretch], law: Series, checkpoint: Checkpoint, progress: bool) -> tuple[Network, dict]:
    data = windows(parts, round(HORIZON_MS / SERVO_MS), LegStep(torque_driven()))
    found = checkpoint.load()
    fit = fit_series.Fit.of(found) if found else fit_series.Fit(fit_series.warm_start(law, parts), data.state0)
    with tqdm(total=1.0, desc="Gauss-Newton", disable=not progress, bar_format=BAR) as bar:
        while not fit.done:
            bar.reset()
            for share in fit_series.improve(fit, law, data):
                bar.update(share - bar.n)
            bar.set_postfix_str(f"step {fit.steps}, angles to {fit.deviation:.2g} rad")
            checkpoint.save(fit.arrays)
    figures = {"windows": len(data) * LANES, "steps": fit.steps, "deviation_rad": fit.deviation}
    return Network(law, fit.weights), figures


class Checkpoint:
    """Arrays on disk beside the model file, tied to the arguments of the call by their text."""

    def __init__(self, out: Path, about: dict, resume: bool) -> None:
        self._path, self._about, self._resume = out.with_name(out.name + ".checkpoint.npz"), json.dumps(about, sort_keys=True), resume

    def load(self) -> dict[str, np.ndarray] | None:
        """What was saved last, if resuming and there is something."""
        if not (self._resume and self._path.exists()):
            return None
        with np.load(self._path, allow_pickle=False) as file:
            arrays = dict(file)
        if str(arrays.pop("about", "")) != self._about:
            raise ModelError(f"'{self._path}' belongs to other data or other settings: train without resume.")
        return arrays

    def save(self, arrays: dict[str, np.ndarray]) -> None:
        """Replaces what was saved."""
        self._path.parent.mkdir(parents=True, exist_ok=True)
        temporary = self._path.with_name(self._path.name + ".tmp")
        with temporary.open("wb") as file:
            np.savez(file, about=self._about, **arrays)
        temporary.replace(self._path)

    def remove(self) -> None:
        """Training is over."""
        self._path.unlink(missing_ok=True)


def versions(law: Law) -> dict[str, str]:
    """Of what the weights depend on."""

    def found() -> Iterator[tuple[str, str]]:
        for package in ("hamr", "numpy", "scipy", "numba", *(["torch"] if law.kind == Mlp.kind else [])):
            try:
                yield package, version(package)
            except PackageNotFoundError:
                continue

    return dict(found())
