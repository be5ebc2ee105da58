"""Names of the frames of REP 103 and REP 105, and of the topics that carry them."""

from __future__ import annotations

MAP = "map"
"""World: east, north, up."""
ODOM = "odom"
"""Where the estimate counts from; here the same as `MAP`, since the estimate does not jump."""
BASE = "base_link"
"""Body by its estimated pose: forward, left, up."""
TRUE_BASE = "base_link_true"
"""Body by its true pose."""


def optical(camera: str, prefix: str = "") -> str:
    """Frame of a camera: right, down, forward (REP 103)."""
    return f"{prefix}camera_{camera}_optical"
