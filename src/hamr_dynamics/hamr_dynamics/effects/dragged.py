"""What a motion drags along and leaves behind at a limit: bristles of dry friction, the polarisation of a piezo."""

from __future__ import annotations

from ..scalar import LITTLE, maximum


def dragged(z, way, length, limit=1.0):
    """dz = (dx - |dx| z / limit) / length along a straight way x: second order in it, and stable however long it is.

    Args:
        z: before, within +-limit. way: signed. length: over which it is dragged while it is far from its limit.

    Returns:
        z after, and dz / dx there.
    """
    ahead, far = way / length, maximum(way, -way)
    passed = far / (length * limit)
    keep = 1.0 / (1.0 + passed + 0.5 * passed * passed)  # exp(-passed)
    new = keep * (z + ahead * (1.0 + 0.5 * passed))
    return new, (1.0 + passed) * keep * (1.0 - way / (far + LITTLE) * new / limit) / length
