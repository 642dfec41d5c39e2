"""A race of fits of one record, of which only those that may win go on to the end."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from .descent import descend
from .fit import Fit, begun, ended, explains
from .parameters import Free
from .threads import at_once
from .weighed import Weighed

FEW, SOON = 4, 3e-3  # steps, and relative decrease of cost, after which each waits for the others
NEAR, FAR = 1.1, 4.0  # times the least cost, up to which they go on to the end, or at all


def raced(
    weighed: Weighed, starts: Iterable[tuple[Sequence[Free], np.ndarray]], known: Sequence[Fit] = (), *, near: float = NEAR,
) -> list[Fit]:  # fmt: skip
    """Fits from several starts, on to the end only of those that cost less than `near` times the least.

    Where one comes near the noise in a few steps, or is known to, those far from it by then are left there.

    Args:
        starts: free numbers, and their values (P,) in scales. known: other fits of the same readings.

    Raises:
        BagError: the model diverges under the record's drives.
    """
    part = weighed.fitted
    model = part.model
    points = at_once(lambda start: descend(part, begun(weighed, *start), steps=FEW, tolerance=SOON), starts)
    explained = any(explains(part, part.sensors(at.s).read(at.run, model.reading_step, model.starts)) for at in points)
    explained = explained or any(explains(weighed, fit.reading) for fit in known)
    far = FAR * min(fit.cost for fit in (*points, *known)) if explained else np.inf
    points = at_once(lambda at: descend(part, at, tolerance=SOON) if at.steps == FEW and at.cost < far else at, points)
    last = min(far, near * min((at.cost for at in points), default=0.0))
    return at_once(lambda at: ended(weighed, descend(part, at) if at.cost < last else at), points)
