"""What a policy sees: names, units, order and scales, in this one place.

The paper's policies see body position, leg angles and the rates of both. Here x, y and yaw are left out, or taken relative to
the start of the primitive, and the commanded direction is added. Each value is centred and divided by its typical size.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hamr_description.errors import ConfigError
from hamr_description.names import JOINTS
from hamr_description.posture import stand_height
from hamr_description.units import length_to_si

from .state import State, attitude, wrap


@dataclass(frozen=True, slots=True)
class Field:
    """Some values of the observation.

    Attributes:
        name: of the quantity.
        parts: what its values belong to.
        unit: of all of them.
        centre, scale: in that unit; networks see (value - centre) / scale.
    """

    name: str
    parts: tuple[str, ...]
    unit: str
    scale: float
    centre: float = 0.0


XYZ = ("x", "y", "z")
#: Every quantity that a policy may see; scales are the sizes met in a walk.
FIELDS = {
    field.name: field
    for field in (
        Field("height", ("z",), "m", 1e-3, centre=length_to_si(stand_height())),
        Field("tilt", ("roll", "pitch"), "rad", 0.1),
        Field("heading", ("yaw",), "rad", 0.5),
        Field("place", ("x", "y"), "m", 0.05),
        Field("velocity", XYZ, "m/s", 0.2),
        Field("angular_velocity", XYZ, "rad/s", 10.0),
        Field("hip_angle", JOINTS, "rad", 0.2),
        Field("hip_rate", JOINTS, "rad/s", 50.0),
        Field("command", ("direction",), "1", 1.0),
    )
}
_ALWAYS = ("height", "tilt", "velocity", "angular_velocity", "hip_angle", "hip_rate", "command")
#: Choices of what is seen of x, y and yaw, the last two relative to the start of the primitive.
VIEWS = {
    "nowhere": _ALWAYS,
    "heading": (*_ALWAYS, "heading"),
    "place": (*_ALWAYS, "heading", "place"),
}
DEFAULT_VIEW = "heading"


def components(view: str) -> list[dict]:
    """Each value of an observation, in order: name, unit, centre, scale. ConfigError for an unknown view."""
    if view not in VIEWS:
        raise ConfigError(f"There is no view '{view}' of the state: known are {', '.join(VIEWS)}.")
    fields = [FIELDS[name] for name in VIEWS[view]]
    return [
        {"name": f"{field.name}.{part}", "unit": field.unit, "centre": field.centre, "scale": field.scale}
        for field in fields
        for part in field.parts
    ]


def place(state: State) -> np.ndarray:
    """(n, 3): x m, y m, yaw rad in the world; the start of a primitive is one of these."""
    return np.column_stack([state.position[:, :2], attitude(state.quaternion)[2]])


def relative(here: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Places (n, 3) seen from starts (n, 3): x along the heading at the start, y to its left, yaw within half a turn."""
    dx, dy = here[:, 0] - start[:, 0], here[:, 1] - start[:, 1]
    c, s = np.cos(start[:, 2]), np.sin(start[:, 2])
    return np.column_stack([c * dx + s * dy, c * dy - s * dx, wrap(here[:, 2] - start[:, 2])])


def observe(view: str, state: State, command: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Observations (n, size) float32, in the units of `components`.

    Args:
        view: key of VIEWS.
        state: n robots.
        command: (n,) +1 or -1.
        start: (n, 3) from `place`, where the primitive began.
    """
    roll, pitch, _ = attitude(state.quaternion)
    seen = relative(place(state), start)
    values = {
        "height": state.position[:, 2:],
        "tilt": np.column_stack([roll, pitch]),
        "heading": seen[:, 2:],
        "place": seen[:, :2],
        "velocity": state.velocity,
        "angular_velocity": state.angular_velocity,
        "hip_angle": state.angles,
        "hip_rate": state.rates,
        "command": command[:, None],
    }
    return np.concatenate([values[name] for name in VIEWS[view]], axis=1, dtype=np.float32, casting="same_kind")
