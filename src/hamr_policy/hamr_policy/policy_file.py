"""What a policy file says about itself, and whether it fits this robot."""

from __future__ import annotations

import json
from pathlib import Path

from hamr_description.errors import ConfigError, ModelError
from hamr_description.names import JOINTS
from hamr_description.rates import SERVO_HZ, TARGET_HZ

from .observation import components
from .task import TARGET_LIMIT, TASKS

FORMAT = "hamr policy 1"
KEY = "hamr"  # of the JSON text among the metadata of the ONNX file
INPUT, OUTPUT = "observation", "target"  # (n, size) float32 in the units of `components`; (n, 8) float32 rad


def interface(task: str, view: str) -> dict:
    """What must be equal between a policy and the robot that it drives."""
    return {
        "format": FORMAT,
        "task": task,
        "directions": {f"{sign:+d}": name for sign, name in TASKS[task].directions.items()},
        "observation": [{"name": row["name"], "unit": row["unit"]} for row in components(view)],
        "action": {"name": "target hip angle", "joints": list(JOINTS), "unit": "rad", "limit": TARGET_LIMIT},
        "target_hz": TARGET_HZ,
        "servo_hz": SERVO_HZ,
    }


def check(path: str | Path, text: str | None) -> dict:
    """The description in a policy file; ModelError says in one sentence what does not fit."""
    try:
        about = json.loads(text or "")
    except ValueError:
        raise ModelError(f"'{path}' does not say what it was made for: use a file that `hamr train policy` wrote.") from None
    if not isinstance(about, dict) or about.get("task") not in TASKS:
        raise ModelError(f"Policy '{path}' has no task that this robot knows ({', '.join(TASKS)}).")
    try:
        wanted = interface(about["task"], about.get("view", ""))
    except ConfigError as error:
        raise ModelError(f"Policy '{path}' does not fit: {error}") from None
    for name, here in wanted.items():
        if about.get(name) != here:
            raise ModelError(f"Policy '{path}' was made for another robot ({name}: {_short(about.get(name), here)}): train it anew.")
    return about


def _short(there: object, here: object) -> str:
    """The first difference."""
    if isinstance(there, list) and isinstance(here, list):
        for i, (a, b) in enumerate(zip(there, here, strict=False)):
            if a != b:
                return f"{i}: {_short(a, b)}"
        return f"{len(there)} values, here {len(here)}"
    if isinstance(there, dict) and isinstance(here, dict):
        key = next(key for key in (*here, *there) if there.get(key) != here.get(key))
        return f"{key}: {_short(there.get(key), here.get(key))}"
    return f"{there}, here {here}"
