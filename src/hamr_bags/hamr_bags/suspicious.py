"""Channels that look wrong though the bag is whole: dead, saturated, or at an end stop."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hamr_description.names import JOINTS, Topic
from hamr_description.numbers import value
from hamr_description.units import length_to_si

#: Share of samples at 0 or 225 V from which a drive channel counts as saturated; Gaussian noise of 64 V has 0.08.
SATURATED = 0.25


def suspicious(topic: str, values: np.ndarray) -> Iterator[str]:
    """Sentences about the channels (n, 8) of a servo topic, SI units, that deserve a look."""
    for j in np.flatnonzero(np.ptp(values, axis=0) == 0) if len(values) > 1 else ():
        yield f"{topic}: {JOINTS[j]} never changes"
    if topic == Topic.SERVO_VOLTAGES:
        low, high = value("actuator.ground_voltage"), value("actuator.bias_voltage")
        count, allowed, where = ((values <= low) | (values >= high)).sum(axis=0), SATURATED, f"at {low:g} or {high:g} V"
    elif topic == Topic.SERVO_ACTUATORS:
        count, allowed, where = (np.abs(values) >= length_to_si(value("actuator.stop"))).sum(axis=0), 0.0, "at an end stop"
    else:
        return
    for j in np.flatnonzero(count > allowed * len(values)):
        yield f"{topic}: {JOINTS[j]} is {where} in {count[j]} of {len(values)} samples"
