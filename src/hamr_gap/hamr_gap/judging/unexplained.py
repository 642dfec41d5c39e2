"""Whether what a model leaves of the readings is noise, whatever the law behind it may be.

Sensors on the two sides of a transmission have noise of their own, white or not: what both of them show is motion that the model lacks.
Noise that is slow beside a block seems to be shared in one block and to be opposed in the next.
"""

from __future__ import annotations

import numpy as np

from ..fitting.fit import Fit
from ..fitting.weighed import Weighed
from ..naming.blocks import THROUGHOUT
from ..naming.hypothesis import blocks_of, left_of, residual

SHARED = 1.0  # rms in noise of a sample, that both sensors of a joint must show
OFTEN = 0.2  # of the blocks, in which they must: a hit that the model has a little late is no law
OUTSIZE = 5.0  # times what a block usually shows: more counts no more, for it makes nobody less sure
#: Rms in noise of a reading, that one sensor must show as often: no coloured noise is so much larger than its white part.
ALONE = 10.0


def structural(weighed: Weighed, judged: np.ndarray, found: Fit) -> bool:
    """Whether both sensors of a joint show the same beside a fit; where no joint has two, whether they show far more than noise."""
    both = shared(weighed, judged, found)
    if not len(both):
        return bool(np.quantile(left_of(weighed, judged, found.reading)[1], 1.0 - OFTEN) > ALONE**2)
    most = OUTSIZE * np.median(np.abs(both))
    each = np.clip(both, -most, most)
    surely = each.mean() > THROUGHOUT * each.std(ddof=1) / np.sqrt(len(each))
    return bool(surely and np.quantile(both, 1.0 - OFTEN) > weighed.model.mean * SHARED**2)


def shared(weighed: Weighed, judged: np.ndarray, found: Fit) -> np.ndarray:
    """(b,) mean product of what both sensors of a joint show beside a fit, in units of their noise, of each block; empty for one sensor."""
    model = weighed.model
    joints, other = len(model.machine.joints), [c for c in model.record.channels if not model.machine.motion_of(c)]
    sides = {own: c for c, own in enumerate(model.own) if own < joints or model.machine.channels[own] in other}
    pairs = [(c, sides[own + joints]) for own, c in sides.items() if own < joints and own + joints in sides]
    left = residual(weighed, found)
    rows = np.flatnonzero(judged.any(1))
    return np.array([np.nanmean([left[part, a] * left[part, b] for a, b in pairs]) for part in blocks_of(weighed, rows) if pairs])
