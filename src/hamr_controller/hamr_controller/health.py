"""What a node has to tell about itself: figures, what it refused, what it is short of. Becomes one status in /diagnostics."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from enum import IntEnum
from time import monotonic

FRESH_S = 5.0  # how long a refusal stays in the status
_BURST = 10  # refusals told to the log, and kept for the status, in that time


class Level(IntEnum):
    """As in diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2


class Health:
    """Counts and remembers; tells the log about each new thing once.

    Attributes:
        figures: name -> value, as the node last set them.
        counts: name -> how often, since start.
    """

    def __init__(self, log: Callable[[Level, str], None], *, clock: Callable[[], float] = monotonic):
        """Args: log, takes a level and a sentence; clock, wall time in s."""
        self.figures: dict[str, object] = {}
        self.counts: Counter[str] = Counter()
        self._log, self._clock = log, clock
        self._states: dict[str, tuple[Level, str]] = {}
        self._refusals: dict[str, float] = {}  # sentence -> when it was last refused

    def refuse(self, sentence: str) -> None:
        """An input was refused. A sentence is logged once while it is fresh, and no more than a few in that time."""
        self.counts["refused"] += 1
        known = self._fresh()
        if sentence in known:
            known[sentence] = self._clock()
        elif len(known) < _BURST:
            known[sentence] = self._clock()
            self._log(Level.WARN, sentence)

    def _fresh(self) -> dict[str, float]:
        """The refusals that still count."""
        now = self._clock()
        self._refusals = {sentence: at for sentence, at in self._refusals.items() if now - at < FRESH_S}
        return self._refusals

    def state(self, topic: str, level: Level, sentence: str) -> None:
        """Something is as it is until said otherwise: logged when it changes. An OK state is told in the log, not in the status."""
        if self._states.get(topic, (Level.OK, "")) != (level, sentence):
            self._states[topic] = (level, sentence)
            if sentence:
                self._log(level, sentence)

    def status(self) -> tuple[Level, str, dict[str, str]]:
        """Worst level, its sentences, and all figures and counts as text."""
        told = [state for state in self._states.values() if state[0] > Level.OK]
        told += [(Level.WARN, sentence) for sentence in self._fresh()]
        level = max((level for level, _ in told), default=Level.OK)
        values = {**self.figures, **self.counts}
        return level, " ".join(sentence for _, sentence in told) or "ok", {name: _text(value) for name, value in values.items()}


def _text(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
