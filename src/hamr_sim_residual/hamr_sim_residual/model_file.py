"""Residual model files: one JSON object of plain numbers and text, which no reader can execute.

Floats are written with the digits that give them back to the bit. A file states for what it was made (joints, units, rate, the
physics it corrects); `load` refuses whatever does not fit this robot.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path

import numpy as np

from hamr_description.errors import ModelError
from hamr_description.names import JOINTS, LEGS
from hamr_description.rates import SERVO_HZ
from hamr_dynamics.plant import flatten

from .network import LAWS, Network
from .simple import simple_parameters

FORMAT = "hamr residual model 1"
UNITS = {"angle": "rad", "rate": "rad/ms", "acceleration": "rad/ms^2", "voltage": "V from neutral", "torque": "N mm"}
FRAME = "mirrored front-left leg"
#: What the roll-outs in training see of HAMR-simple; stops, foot and chassis may change without touching the model.
PHYSICS = ("mass", "com", "inertia", "stiffness", "damping", "hip")


@dataclass(frozen=True, slots=True)
class Model:
    """A learned torque law and where it comes from.

    Attributes:
        network: law and weights.
        training: method, seed, data (digests, seconds), versions, losses: JSON-able, for people.
    """

    network: Network
    training: dict = field(default_factory=dict)


def physics_hash() -> str:
    """Hash over the parameters of HAMR-simple that a residual model corrects, 16 hex digits."""
    legs = {leg: {k: v for k, v in flatten(simple_parameters(leg)).items() if k.split(".")[0] in PHYSICS} for leg in LEGS}
    return hashlib.sha256(json.dumps(legs, sort_keys=True).encode()).hexdigest()[:16]


def save(model: Model, path: str | Path) -> Path:
    """Writes a model file, whole or not at all; equal models give equal bytes."""
    law = model.network.law
    content = {
        "format": FORMAT, "joints": list(JOINTS), "frame": FRAME, "units": UNITS, "servo_hz": SERVO_HZ, "physics": physics_hash(),
        "law": {"kind": law.kind, **asdict(law)}, "training": model.training, "weights": model.network.values.tolist(),
    }  # fmt: skip
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(path.name + f".{os.getpid()}.tmp")
    temporary.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n")
    os.replace(temporary, path)
    return path


def load(path: str | Path) -> Model:
    """Reads a model file; ModelError says in one sentence what does not fit."""
    try:
        content = json.loads(Path(path).read_text())
    except FileNotFoundError:
        raise ModelError(f"There is no residual model '{path}': give the path of a file that `hamr train residual` wrote.") from None
    except (OSError, UnicodeDecodeError, ValueError):
        raise ModelError(f"'{path}' is no residual model: it is not readable as JSON text.") from None
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise ModelError(f"'{path}' is no residual model of this version: its format is not '{FORMAT}'.")
    must = {
        "joints": list(JOINTS), "frame": FRAME, "units": UNITS, "servo_hz": SERVO_HZ, "physics": physics_hash(),
    }  # fmt: skip
    for key, expected in must.items():
        if content.get(key) != expected:
            raise ModelError(f"Residual model '{path}' is for another robot ({key}: {content.get(key)}, here {expected}): train it anew.")
    if unknown := sorted(set(content) - {*must, "format", "law", "training", "weights"}):
        raise ModelError(f"Residual model '{path}' has an unknown entry '{unknown[0]}'.")
    law = _law(path, content.get("law"))
    return Model(Network(law, _weights(path, content.get("weights"), len(law.rows))), content.get("training") or {})


def _law(path, stated):
    known = LAWS.get(stated.get("kind")) if isinstance(stated, dict) else None
    if known is None:
        raise ModelError(f"Residual model '{path}' has an unknown law {stated}: known are {', '.join(LAWS)}.")
    given = {k: v for k, v in stated.items() if k != "kind"}
    if set(given) != {f.name for f in fields(known)}:
        needed = ", ".join(f.name for f in fields(known))
        raise ModelError(f"Residual model '{path}' does not state its law '{known.kind}' in full: it needs {needed}.")
    try:
        return known(**{k: tuple(v) if isinstance(v, list) else v for k, v in given.items()})
    except (TypeError, ValueError) as error:
        raise ModelError(f"Residual model '{path}' has an impossible law: {error}.") from None


def _weights(path, stated, count: int) -> np.ndarray:
    numbers = isinstance(stated, list) and all(type(x) in (int, float) and math.isfinite(x) for x in stated)
    if not numbers or len(stated) != count:
        raise ModelError(f"Residual model '{path}' needs {count} finite weights for its law.")
    return np.array(stated, float)
