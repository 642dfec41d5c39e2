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
        self._coarse, self._added, self.exact = None, np.zeros_like(run), True
        coarse = weighed.coarse
        if coarse and coarse.substeps < weighed.model.substeps and np.isfinite(other := coarse.runs(free, x, self._samples)[0]).all():
            self._coarse, self._added, self.exact = coarse, run - other, False

    def near(self, x: np.ndarray) -> np.ndarray:
        """(K, n, channels) of (K, P)."""
        return self.near_rows(self._fine.rows(self._free, x))

    def near_rows(self, rows: np.ndarray) -> np.ndarray:
        """The same of (K, rows) lane parameters, which may have more in them than what is free here."""
        return self._fine.run_rows(rows, self._samples) if self.exact else self._corrected(rows)

    def beside(self, x: np.ndarray) -> np.ndarray:
        """As `near`, of (K, P) so near that only what it differs by from the point is wanted: coarse, whatever `exact`."""
        rows = self._fine.rows(self._free, x)
        return self._corrected(rows) if self._coarse else self._fine.run_rows(rows, self._samples)

    def _corrected(self, rows: np.ndarray) -> np.ndarray:
        return self._added + self._coarse.run_rows(rows, self._samples)

    def at(self, x: np.ndarray, run: np.ndarray) -> np.ndarray:
        """(n, channels) exact at x (P,), of which `near` made `run`; what is near is about x from now on."""
        if self._coarse is None:
            return run
        fine = run if self.exact else self._fine.runs(self._free, x, self._samples)[0]
        near = self.beside(x[None])[0] if self.exact else run
        self._added = self._added + (fine - near)
        return fine

    @property
    def finest(self) -> bool:
        """Whether nothing is left to refine."""
        return self._coarse is None

    def refine(self) -> None:
        """Fine steps from now on: of what is `near`, and when told again of what is `beside` too."""
        self._coarse, self.exact = None if self.exact else self._coarse, True
