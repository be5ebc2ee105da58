"""Names of the coordinate frames, after REP 103 and REP 105."""

from __future__ import annotations

MAP = "map"
"""World frame: east, north, up."""
ODOM = "odom"
"""Origin of the estimate; here the same as `MAP`, because the estimate does not jump."""
BASE = "base_link"
"""Body frame at the estimated pose: forward, left, up."""
TRUE_BASE = "base_link_true"
"""Body frame at the true pose, which a real vehicle would not know."""


def optical(camera: str, prefix: str = "") -> str:
    """Return the optical frame of a camera: right, down, forward (REP 103).

    Args:
        camera: Name of the camera.
        prefix: Prefix of the vehicle's frames, such as `vehicle_2/`; empty for the first.
    """
    return f"{prefix}camera_{camera}_optical"
