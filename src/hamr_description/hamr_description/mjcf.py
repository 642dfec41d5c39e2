"""The three MuJoCo models as XML text: `full`, `simple` and `simple_published` (g, mm, ms, N, V)."""

from __future__ import annotations

from .mjcf_full import full
from .mjcf_simple import simple, simple_published

__all__ = ["full", "simple", "simple_published"]
