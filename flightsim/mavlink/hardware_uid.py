"""Identity of a flight controller, by which ground stations and logs distinguish vehicles."""

from __future__ import annotations

_LENGTH = 18
"""Bytes of `uid2` in AUTOPILOT_VERSION."""


def hardware_uid(system_id: int) -> bytes:
    """Return the serial number of a vehicle's board, the same in each of its runs.

    Ground stations know a vehicle again by it.

    Args:
        system_id: System id of the vehicle.

    Returns:
        18 bytes.
    """
    return b"AeroScene" + system_id.to_bytes(_LENGTH - len(b"AeroScene"), "big")
