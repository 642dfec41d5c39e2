"""One error family. A message says what is wrong, where, and what to do."""

from __future__ import annotations


class HamrError(Exception):
    """Base of all errors that a user can cause; the command line prints it as one sentence."""


class ConfigError(HamrError):
    """A parameter, number, name or file does not fit."""


class BagError(HamrError):
    """A bag is missing, foreign, truncated, empty or inconsistent."""


class ModelError(HamrError):
    """A policy or residual model file does not fit this robot."""
