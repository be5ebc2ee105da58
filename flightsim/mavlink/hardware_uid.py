"""Identity of a flight controller, by which ground stations and logs distinguish vehicles."""

from __future__ import annotations

_LENGTH = 18
"""Bytes of `uid2` in AUTOPILOT_VERSION."""


def hardware_uid(system_id: int) -> bytes:
    """Return the serial number of a vehicle's board (18 bytes), the same in each of its runs."""
    return b"AeroScene" + system_id.to_bytes(_LENGTH - len(b"AeroScene"), "big")
