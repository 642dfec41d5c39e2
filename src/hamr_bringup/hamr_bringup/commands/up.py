"""Bring up simulator, controller, policy and recorder as processes, until Ctrl-C or the end of --seconds.

Examples:
  hamr up --backend full --seconds 5
  hamr up --backend residual --policy walk.onnx --command forward --bag out/walk --seconds 5
  hamr up --backend simple --engine mujoco --real-time-factor 0
  hamr up --backend simple --effects effects.yaml --seconds 5
"""

from __future__ import annotations

from dataclasses import asdict, dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    backend: str = "full"
    """full, residual, simple or simple_published."""
    engine: str = "kernel"
    """kernel or mujoco."""
    environment: str = "ground"
    """ground or suspended."""
    friction: float | None = None
    """Coefficient of the ground; the project's if not given."""
    residual: str = ""
    """Residual model file, for the residual backend; the shipped one if not given."""
    effects: str = ""
    """Effects file: what is added to the model (docs/effects.md)."""
    policy: str = ""
    """Policy files, with commas; none: targets come from whoever publishes /leg_targets."""
    command: str = ""
    """What the policy does until /cmd_vel says otherwise: forward, backward, left or right."""
    bag: str = ""
    """Folder of the bag to record."""
    seconds: float = 0.0
    """Simulated time; 0 for no end."""
    real_time_factor: float = 1.0
    """Simulated over wall time; 0 for as fast as possible."""
    samples_per_frame: int = 16
    """Samples kept of each 4 ms in the bag: 16 is 4 kHz, 80 is 20 kHz."""
    seed: int = 0
    """Of the initial state."""
    parameters: str = ""
    """File with parameters of any of the nodes, as ROS 2 has them; what the options set wins."""

    def run(self) -> dict:
        from ..graph import Run
        from ..shipped import RESIDUAL
        from ..supervisor import up

        shipped = str(RESIDUAL) if self.backend == "residual" else ""
        return up(Run(**asdict(self) | {"residual": self.residual or shipped}))
