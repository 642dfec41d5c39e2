"""Linear least squares over what all segments share, each one's own start eliminated."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

#: Noises of a reading by one standard deviation of a start, from where on a probe has as good as diverged. Squares of such slopes, of
#: all readings together, still leave room in a double for a prior's 1, without which directions alike would be singular.
STEEP = 1e5


class Eliminated:
    """Slopes of segments with the starts eliminated: what is left of readings once each start has adapted.

    Segments whose runs diverged pull nowhere, and a start is left as it is in directions whose probe diverged.
    """

    def __init__(self, slopes: np.ndarray) -> None:
        """Args: slopes (s, c, 28)."""
        known = (np.abs(slopes) < STEEP).all(1) & slopes.any(1)
        self._slopes = slopes = np.where(known[:, None], slopes, 0.0)
        self._gram = np.einsum("sci,scj->sij", slopes, slopes, optimize=True)
        blind, which = np.nonzero(~known)
        self._gram[blind, which, which] = 1.0  # of directions that nothing is known of

    def normal(self, columns: np.ndarray, residual: np.ndarray, weight: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(P, P) and (P,) normal equations of columns (s, c, P) against residuals (s, c) of segments with weights (s,)."""
        across = np.matmul(self._slopes.transpose(0, 2, 1), columns)
        solved = np.matmul(np.linalg.inv(self._gram), across) * weight[:, None, None]
        weighted = (columns * weight[:, None, None]).reshape(-1, columns.shape[2])
        flat = columns.reshape(-1, columns.shape[2])
        hessian = flat.T @ weighted - across.reshape(-1, across.shape[2]).T @ solved.reshape(-1, across.shape[2])
        gradient = weighted.T @ _finite(residual).ravel() - np.einsum("sip,si->p", solved, self._pull(residual))
        return hessian, gradient

    def starts(self, residual: np.ndarray, dampings: Sequence[float]) -> np.ndarray:
        """(d, s, 28) steps of the starts that take the most off residuals (s, c), with shares of each direction's curvature added."""
        diagonal = np.einsum("sii->si", self._gram)[:, :, None] * np.eye(self._gram.shape[1])
        return np.linalg.solve(self._gram + np.array(dampings)[:, None, None, None] * diagonal, self._pull(residual)[..., None])[..., 0]

    def _pull(self, residual: np.ndarray) -> np.ndarray:
        return np.einsum("sci,sc->si", self._slopes, _finite(residual), optimize=True)


def _finite(residual: np.ndarray) -> np.ndarray:
    return np.where(np.isfinite(residual).all(1, keepdims=True), residual, 0.0)


def bounded(hessian: np.ndarray, gradient: np.ndarray, x: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """(P,) Newton step that does not push further what already sits on a bound."""
    held = np.zeros(len(x), bool)
    for _ in range(len(x) + 1):
        free = ~held
        step = np.zeros(len(x))
        scale = 1.0 / np.sqrt(np.diag(hessian)[free])
        scaled = hessian[np.ix_(free, free)] * scale[:, None] * scale
        step[free] = scale * np.linalg.solve(scaled + 1e-12 * np.eye(len(scaled)), scale * gradient[free])
        pushing = ((x <= low) & (step < 0)) | ((x >= high) & (step > 0))
        if not (pushing & ~held).any():
            break
        held |= pushing
    return step
