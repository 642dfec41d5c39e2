"""Rates of the control stack, defined once (SEED, section "Leg Control")."""

from __future__ import annotations

SERVO_HZ = 20_000
TARGET_HZ = 250
SUBSTEPS = SERVO_HZ // TARGET_HZ  # servo samples in one target period
SERVO_MS = 1e3 / SERVO_HZ
TARGET_MS = 1e3 / TARGET_HZ
TARGET_NS = 1_000_000_000 // TARGET_HZ
