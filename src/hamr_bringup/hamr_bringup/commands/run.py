"""Run one node, as `ros2 run` does, where no ros2 command is installed.

Examples:
  hamr run                                  lists packages and executables
  hamr run hamr_sim_full sim
  hamr run hamr_sim_residual sim --ros-args -p residual:=out/residual.onnx
"""

from __future__ import annotations

import importlib
import sys
from dataclasses import dataclass

from hamr_description.errors import ConfigError

from ..executables import executables


@dataclass(frozen=True, slots=True)
class Command:
    """`words`: package, executable, and what the node gets; none lists them."""

    words: tuple[str, ...]

    @classmethod
    def from_words(cls, words: list[str]) -> Command:
        """Everything behind the executable is the node's, so nothing is read here but a lone --help."""
        if words[:1] in (["-h"], ["--help"]):
            sys.stdout.write(f"usage: hamr run [PACKAGE EXECUTABLE [ARGUMENT ...]]\n\n{__doc__}")
            raise SystemExit(0)
        return cls(tuple(words))

    def run(self) -> dict:
        table = executables()
        if not self.words:
            return {"rows": [{"package": package, "executable": name} for package, name in table]}
        if self.words[:2] not in table:
            known = ", ".join(" ".join(pair) for pair in table)
            raise ConfigError(f"'{' '.join(self.words[:2])}' is not a package and its executable (known: {known}).")
        sys.argv = [self.words[1], *self.words[2:]]
        importlib.import_module(table[self.words[:2]]).main()
        return {}
