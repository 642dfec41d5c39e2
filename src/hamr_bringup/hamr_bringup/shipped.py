"""The models that come with the project; `models/README.md` beside each says which command made it."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

POLICY = Path(str(files("hamr_policy"))) / "models" / "walk.onnx"
TURN_POLICY = POLICY.with_name("turn.onnx")
RESIDUAL = Path(str(files("hamr_sim_residual"))) / "models" / "residual.json"
