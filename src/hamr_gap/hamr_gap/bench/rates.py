"""Shares of cases with 95 % intervals that know which cases belong together."""

from __future__ import annotations

from collections.abc import Hashable, Iterable

import numpy as np
from scipy.stats import beta

LEVEL = 0.95


def rate(hits: Iterable[bool], clusters: Iterable[Hashable] | None = None) -> str:
    """A share with its interval: "93 % (81..99, n = 42)"; "-" of nothing.

    Args:
        hits: one for each case. clusters: what each belongs to, such as the law that was hidden in it; each to itself if not given.
    """
    hit = np.array(list(hits), bool)
    if not len(hit):
        return "-"
    low, high = interval(hit, list(clusters) if clusters is not None else range(len(hit)))
    return f"{100 * hit.mean():.0f} % ({100 * low:.0f}..{100 * high:.0f}, n = {len(hit)})"


def interval(hit: np.ndarray, clusters: Iterable[Hashable]) -> tuple[float, float]:
    """Clopper-Pearson interval of the share of (n,) hits, for as many independent cases as the spread between clusters leaves.

    Korn and Graubard (Survey Methodology 24, 1998), without their quantiles of t: n over the design effect. Where all or none hit, no
    spread tells what a cluster's cases have in common, and each counts as one.
    """
    n, p = len(hit), float(hit.mean())
    own = np.unique([repr(c) for c in clusters], return_inverse=True)[1]
    count = own.max() + 1
    if p in (0.0, 1.0):
        independent = count
    else:
        off = np.bincount(own, hit - p)
        effect = count / max(count - 1, 1) * float(off @ off) * (n - 1) / (n * n * p * (1.0 - p))  # of two unbiased variances
        independent = n / max(effect, 1.0)
    k, tail = p * independent, 0.5 * (1.0 - LEVEL)
    low = beta.ppf(tail, k, independent - k + 1.0) if p > 0.0 else 0.0
    high = beta.isf(tail, k + 1.0, independent - k) if p < 1.0 else 1.0
    return float(low), float(high)
