"""Where a gap is: in which channel, when, at which amplitude, in which band, and whether it drifts or remembers."""

from __future__ import annotations

import numpy as np
from scipy.signal import welch

from ..fitting.fit import Fit
from ..fitting.weighed import Weighed
from ..naming.hypothesis import residual

BANDS = 6


def where(weighed: Weighed, found: Fit) -> list[str]:
    """One sentence for each finding, largest first, about a fit's residual (in units of the noise of a reading)."""
    model, left = weighed.model, residual(weighed, found)
    rows = weighed.chosen.any(1)
    left, run = left[rows], found.run[rows]
    seconds = model.machine.to_si["T"]
    power = np.nanmean(left**2, axis=0)
    said = []
    for c, channel in enumerate(model.record.channels):
        said.append(f"{channel}: residual {np.sqrt(power[c]):.1f} times the noise")
    largest = int(np.argmax(power))
    x, q = left[:, largest], run[:, largest]
    if power[largest] < 2.0:
        return said
    rate = 1.0 / (model.reading_step * seconds)
    f, spectrum = welch(np.nan_to_num(x), rate, nperseg=min(len(x), 1024))
    edges = np.geomspace(max(f[1], 1e-9), f[-1], BANDS + 1)
    share = [spectrum[(f >= a) & (f < b)].sum() / spectrum.sum() for a, b in zip(edges[:-1], edges[1:], strict=True)]
    k = int(np.argmax(share))
    said.append(f"{model.record.channels[largest]}: {100 * share[k]:.0f} % of it lies between {edges[k]:.3g} and {edges[k + 1]:.3g} Hz")
    v = np.gradient(q)
    for name, by in (("readings", np.abs(q - q.mean())), ("rates of it", np.abs(v))):
        order = np.argsort(by)
        low, high = (np.mean(x[part] ** 2) for part in (order[: len(order) // 3], order[-len(order) // 3 :]))
        if max(low, high) > 2.0 * min(low, high):
            said.append(f"{model.record.channels[largest]}: {high / low:.1f} times as strong at large {name} as at small ones")
    thirds = [np.mean(part**2) for part in np.array_split(x, 3)]
    if max(thirds[0], thirds[2]) > 2.0 * min(thirds[0], thirds[2]):
        more = thirds[2] / thirds[0]
        said.append(f"{model.record.channels[largest]}: {more:.1f} times as strong at the end as at the beginning: it drifts")
    return said
