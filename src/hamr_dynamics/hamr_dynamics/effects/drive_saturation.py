"""The drive stops growing with its command."""

from __future__ import annotations

from ..scalar import clip, maximum, sqrt
from .law import Effect, Form, Input, Parameter


def soft(x: Input, p, z):
    """u / sqrt(1 + c u^2)."""
    return x.u / sqrt(1.0 + p["curvature"] * x.u * x.u), z


def shoulder(x: Input, p, z):
    """u / sqrt(1 + s |u| + c u^2): levels off more slowly, as an arctangent does."""
    return x.u / sqrt(1.0 + p["slope"] * maximum(x.u, -x.u) + p["curvature"] * x.u * x.u), z


def hard(x: Input, p, z):
    """u within +-1/sharpness."""
    limit = 1.0 / p["sharpness"]
    return clip(x.u, -limit, limit), z


def sides(x: Input, p, z):
    """u within -1/lower and +1/upper."""
    return clip(x.u, -(1.0 / p["lower"]), 1.0 / p["upper"]), z


CURVATURE = Parameter("curvature", "1/U^2", 0.05, 0.0, 5.0, "one over the squared limit")
THRESHOLDS = (0.36, 0.4, 0.45, 0.5, 0.56, 0.63, 0.72, 0.85)  # one over a limit has no effect until the limit is met, and then much

EFFECT = Effect(
    name="drive_saturation",
    part="actuator",
    summary="The drive levels off at large commands.",
    forms=(
        Form("soft", "drive", soft, (CURVATURE,), order=4),
        Form("shoulder", "drive", shoulder, (Parameter("slope", "1/U", 0.05, 0.0, 5.0, "how early it bends"), CURVATURE), order=4),
        Form("hard", "drive", hard, (Parameter("sharpness", "1/U", 0.6, 0.0, 5.0, "one over the limit", screen=THRESHOLDS),), order=4),
        Form("sides", "drive", sides, (
            Parameter("upper", "1/U", 0.6, 0.0, 5.0, "one over the upper limit", screen=THRESHOLDS),
            Parameter("lower", "1/U", 0.6, 0.0, 5.0, "one over the lower limit, as a positive number", screen=THRESHOLDS),
        ), order=4),
    ),
    experiment="three amplitudes up to the rails",
    source="gap_method 3.2; amplifiers near their rails",
)  # fmt: skip
