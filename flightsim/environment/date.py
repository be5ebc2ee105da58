"""The date of the simulated world, the same in every run."""

EPOCH_US = 1_767_225_600_000_000
"""Time of the simulation's start in microseconds since 1970: 2026-01-01 00:00 UTC."""
