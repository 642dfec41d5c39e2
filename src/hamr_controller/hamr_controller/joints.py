"""Values of a message by joint name, whatever order it has them in."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from hamr_description.errors import HamrError
from hamr_description.names import JOINTS

_INDEX = {joint: j for j, joint in enumerate(JOINTS)}


class BadMessage(HamrError):
    """A message that must have no effect."""


def ordered(topic: str, names: Sequence[str], values: Sequence[float]) -> np.ndarray:
    """Values (8,) in canonical order, finite.

    Raises:
        BadMessage: an unknown, missing or repeated joint, a missing value, or one that is not finite.
    """
    if tuple(names) != JOINTS:
        for name, count in Counter(names).items():
            if name not in _INDEX:
                raise BadMessage(f"{topic} names '{name}', which is no joint of this robot; its joints are {', '.join(JOINTS)}.")
            if count > 1:
                raise BadMessage(f"{topic} names '{name}' {count} times; name each joint once.")
        if missing := [joint for joint in JOINTS if joint not in names]:
            raise BadMessage(f"{topic} lacks '{missing[0]}'; send all {len(JOINTS)} joints.")
    if len(values) != len(names):
        raise BadMessage(f"{topic} has {len(values)} values for {len(names)} joints; send one for each.")
    result = np.empty(len(JOINTS))
    result[[_INDEX[name] for name in names]] = values
    if not np.isfinite(result).all():
        joint = JOINTS[int(np.argmin(np.isfinite(result)))]
        raise BadMessage(f"{topic} has {result[_INDEX[joint]]} for '{joint}'; send finite values.")
    return result
