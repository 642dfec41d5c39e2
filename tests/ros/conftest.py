"""Each test has a ROS domain and a run directory of its own."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import pytest
from harness import Graph, Observer, domain_lock


@pytest.fixture
def graph(tmp_path, monkeypatch):
    """Starts node processes; none outlives the test."""
    domain, descriptor = domain_lock(Path(tempfile.gettempdir(), f"hamr-test-domains-{os.getuid()}"))
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    nodes = Graph(tmp_path)
    yield nodes
    nodes.close()
    os.close(descriptor)


@pytest.fixture
def observe(graph):
    """Makes observers in the graph's domain."""
    made = []

    def make(*topics: str) -> Observer:
        made.append(Observer(*topics))
        return made[-1]

    yield make
    for observer in made:
        observer.close()
