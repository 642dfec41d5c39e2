"""The table of nodes: a module X_node of a package is the executable X, here as in every package's setup.py."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

PACKAGES = ("hamr_sim_full", "hamr_sim_residual", "hamr_controller", "hamr_policy", "hamr_bags")


def executables() -> dict[tuple[str, str], str]:
    """(package, executable) -> module with the node's main()."""
    found = {}
    for package in PACKAGES:
        for file in sorted(Path(find_spec(package).origin).parent.glob("*_node.py")):
            found[package, file.stem.removesuffix("_node")] = f"{package}.{file.stem}"
    return found
