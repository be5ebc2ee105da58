"""Configuration of the decoding."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class DecodingCfg:
    """What decoding does beyond reading numbers; taken away, it shows what it brings."""

    makes_room: bool = True
    """Whether what would overlap goes to the nearest free place that its relation leaves open."""
    mends: bool = True
    """Whether things come where their category has to be: boats afloat, vehicles in their lanes,
    plates before chairs, chairs turned to their tables."""
