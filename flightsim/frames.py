"""Frame conversions for MAVLink: ENU/FLU to NED/FRD, local to geodetic.

All of our code is in ENU and FLU; these functions stand where a message leaves or enters. Both axis
changes are their own inverse, so one function serves both directions.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from aeroscene.scene.origin import metres_per_degree
from autonomy.types import Quaternion, Vector3

_HALF_SQRT_2 = math.sqrt(0.5)


def swap_enu_ned(vector: Vector3) -> Vector3:
    """Convert a vector from ENU to NED, or back."""
    x, y, z = vector
    return (y, x, -z)  # east and north change places, up becomes down


def swap_flu_frd(vector: Vector3) -> Vector3:
    """Convert a vector from FLU to FRD, or back."""
    x, y, z = vector
    return (x, -y, -z)


def swap_quat_enu_flu_ned_frd(quat_wxyz: Quaternion) -> Quaternion:
    """Convert an attitude from FLU-to-ENU to FRD-to-NED, or back; w >= 0.

    The axis changes are half turns: about (1, 1, 0)/sqrt(2) for the world and about x for the body.
    The result is the product of the first, the attitude and the second.
    """
    w, x, y, z = quat_wxyz
    swapped = (
        _HALF_SQRT_2 * (w + z),
        _HALF_SQRT_2 * (x + y),
        _HALF_SQRT_2 * (x - y),
        _HALF_SQRT_2 * (w - z),
    )
    # Both signs are the same attitude; one is chosen so that equal attitudes have equal numbers.
    return swapped if swapped[0] >= 0 else (-swapped[0], -swapped[1], -swapped[2], -swapped[3])


def swap_yaw_enu_ned(yaw_rad: float) -> float:
    """Convert a yaw counter-clockwise from east to a heading clockwise from north, or back.

    Returns:
        The angle in (-pi, pi].
    """
    swapped = math.pi / 2 - yaw_rad
    # The remainder is in [0, 2 pi), so the two signs move the open end from pi to -pi.
    return -((math.pi - swapped) % (2 * math.pi) - math.pi)


def euler_rpy_rad(quat_wxyz: Quaternion) -> Vector3:
    """Return roll, pitch and yaw (intrinsic z-y-x) of an attitude in its own frames.

    Args:
        quat_wxyz: Unit quaternion, body to world; of either pair of frames.

    Returns:
        Angles in radians; roll and yaw in [-pi, pi], pitch in [-pi/2, pi/2].
    """
    w, x, y, z = quat_wxyz
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    # Rounding may carry the sine beyond 1.
    pitch = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
    yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return (roll, pitch, yaw)


@dataclass(frozen=True, slots=True)
class Geodetic:
    """Position on the WGS 84 ellipsoid; altitude above mean sea level."""

    latitude_deg: float
    longitude_deg: float
    altitude_m: float


class LocalFrame:
    """ENU plane tangent to the ellipsoid at an origin.

    It takes the radii of curvature at the origin: within 1 km of it the error stays below 0.2 m,
    and one conversion costs under a microsecond. The vertical is the difference in altitude.

    Attributes:
        origin: Place of the local origin.
        metres_per_degree_north: Length of a degree of latitude there.
        metres_per_degree_east: Length of a degree of longitude there.
    """

    def __init__(self, origin: Geodetic) -> None:
        self.origin = origin
        self.metres_per_degree_north, self.metres_per_degree_east = metres_per_degree(
            origin.latitude_deg, origin.altitude_m
        )

    def geodetic_from_enu(self, position_enu_m: Vector3) -> Geodetic:
        """Return the latitude, longitude and altitude of a local position."""
        east, north, up = position_enu_m
        return Geodetic(
            self.origin.latitude_deg + north / self.metres_per_degree_north,
            self.origin.longitude_deg + east / self.metres_per_degree_east,
            self.origin.altitude_m + up,
        )

    def enu_from_geodetic(self, place: Geodetic) -> Vector3:
        """Return the local position of a latitude, longitude and altitude."""
        return (
            (place.longitude_deg - self.origin.longitude_deg) * self.metres_per_degree_east,
            (place.latitude_deg - self.origin.latitude_deg) * self.metres_per_degree_north,
            place.altitude_m - self.origin.altitude_m,
        )
