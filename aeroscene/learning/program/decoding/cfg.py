"""Configuration of the decoding."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class DecodingCfg:
    """Corrections that decoding makes beyond reading numbers; an ablation turns one off."""

    makes_room: bool = True
    """True moves objects that would overlap to the nearest free place that their relation leaves
    open."""
    mends: bool = True
    """True puts objects where their category has to be: boats afloat, vehicles in their lanes,
    plates before chairs, chairs turned to their tables."""
    rounds: bool = True
    """True gives units other than ground whole centimetres as extents, as curated objects have
    them. A model draws real numbers, and their decimals would give its scenes away."""
