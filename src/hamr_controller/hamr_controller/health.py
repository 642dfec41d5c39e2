"""What a node has to tell about itself: figures, what it refused, what it is short of. Becomes one status in /diagnostics."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from enum import IntEnum
from time import monotonic

FRESH_S = 5.0  # how long a refusal keeps the status at WARN


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
        self._refusal = ""
        self._refused_at = -FRESH_S

    def refuse(self, sentence: str) -> None:
        """An input was refused. The same sentence in a row is logged once while it is fresh."""
        fresh = self._clock() - self._refused_at < FRESH_S
        if not (fresh and sentence == self._refusal):
            self._log(Level.WARN, sentence)
        self.counts["refused"] += 1
        self._refusal, self._refused_at = sentence, self._clock()

    def state(self, topic: str, level: Level, sentence: str) -> None:
        """Something is as it is until said otherwise: logged when it changes. An OK state is told in the log, not in the status."""
        if self._states.get(topic, (Level.OK, "")) != (level, sentence):
            self._states[topic] = (level, sentence)
            if sentence:
                self._log(level, sentence)

    def status(self) -> tuple[Level, str, dict[str, str]]:
        """Worst level, its sentences, and all figures and counts as text."""
        told = [state for state in self._states.values() if state[0] > Level.OK]
        if self._clock() - self._refused_at < FRESH_S:
            told.append((Level.WARN, self._refusal))
        level = max((level for level, _ in told), default=Level.OK)
        values = {**self.figures, **self.counts}
        if self._refusal:
            values["last refused"] = self._refusal
        return level, " ".join(sentence for _, sentence in told) or "ok", {name: _text(value) for name, value in values.items()}


def _text(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
