"""Status reports of the autopilot besides its mode."""

from __future__ import annotations

from dataclasses import dataclass

from autonomy.types import Vector3
from flightsim.autopilot.modes import BatteryWarning
from flightsim.frames import Geodetic


@dataclass(frozen=True, kw_only=True, slots=True)
class Home:
    """Position where a return ends."""

    position_enu_m: Vector3
    geodetic: Geodetic
    yaw_rad: float
    """ENU heading of the vehicle when home was set."""
    is_manual: bool
    """True if a client set it, so that arming keeps it."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Health:
    """Health of the parts.

    Attributes:
        is_armable: True if arming in the present mode would be accepted.
    """

    is_imu_ok: bool = False
    is_mag_ok: bool = False
    is_baro_ok: bool = False
    is_gnss_ok: bool = False
    is_rangefinder_ok: bool = False
    is_attitude_ok: bool = False
    is_position_ok: bool = False
    is_battery_ok: bool = False
    is_geofence_on: bool = True
    is_geofence_ok: bool = False
    is_armable: bool = False


@dataclass(frozen=True, kw_only=True, slots=True)
class PrearmReport:
    """Result of the arming checks, and the reasons against arming if there are any."""

    is_ok: bool
    reasons: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True, slots=True)
class BatteryView:
    """State of the battery as the autopilot sees it."""

    n_cells: int
    voltage_v: float = 0.0
    current_a: float = 0.0
    consumed_mah: float = 0.0
    remaining: float = 1.0
    """State of charge, 0 to 1."""
    warning: BatteryWarning = BatteryWarning.NONE
