"""Runs in coarse steps, with what fine ones add to them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .parameters import Free
from .weighed import Weighed


class Corrected:
    """Runs near a point as fine steps make them, for the price of coarse ones.

    What fine steps add to a run hangs little on the parameters. So it is worked out at one point, where runs are exact, and added to
    coarse runs near by. A model without a coarser one is run as it is.
    """

    def __init__(self, weighed: Weighed, free: Sequence[Free], x: np.ndarray, run: np.ndarray) -> None:
        """About x (P,), in scales, where fine steps make `run`, (n, channels)."""
        self._fine, self._free, self._samples = weighed.model, free, len(run)
        self._coarse, self._added = None, np.zeros_like(run)
        coarse = weighed.coarse
        if coarse and coarse.substeps < weighed.model.substeps and np.isfinite(other := coarse.runs(free, x, self._samples)[0]).all():
            self._coarse, self._added = coarse, run - other

    @property
    def exact(self) -> bool:
        """Whether all runs are."""
        return self._coarse is None

    def near(self, x: np.ndarray) -> np.ndarray:
        """(K, n, channels) of (K, P)."""
        return self.near_rows(self._fine.rows(self._free, x))

    def near_rows(self, rows: np.ndarray) -> np.ndarray:
        """The same of (K, rows) lane parameters, which may have more in them than what is free here."""
        return self._added + (self._coarse or self._fine).run_rows(rows, self._samples)

    def at(self, x: np.ndarray, run: np.ndarray) -> np.ndarray:
        """(n, channels) exact at x (P,), of which `near` made `run`; what is near is about x from now on."""
        if self.exact:
            return run
        fine = self._fine.runs(self._free, x, self._samples)[0]
        self._added = self._added + (fine - run)
        return fine

    def refine(self) -> None:
        """Fine steps from now on."""
        self._coarse, self._added = None, np.zeros_like(self._added)
