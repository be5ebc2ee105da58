"""Conversions between the scene's frames and AirSim's, and numbers packed for the wire."""

from __future__ import annotations

import math
import struct

import msgspec
import numpy as np

from autonomy.types import Quaternion, Vector3
from flightsim.environment.date import EPOCH_US
from flightsim.frames import Geodetic, swap_enu_ned, swap_flu_frd, swap_quat_enu_flu_ned_frd
from scenarios.airsim.messages import GeoPoint, Pose, Quaternionr, Vector3r
from scenarios.airsim.methods import RpcError


def ned(vector_enu: Vector3) -> Vector3r:
    """A vector of the world."""
    return Vector3r(*map(float, swap_enu_ned(vector_enu)))


def frd(vector_flu: Vector3) -> Vector3r:
    """A vector of the body."""
    return Vector3r(*map(float, swap_flu_frd(vector_flu)))


def attitude(quat_wxyz: Quaternion) -> Quaternionr:
    """An attitude from FLU to ENU, as one from FRD to NED."""
    return Quaternionr(*map(float, swap_quat_enu_flu_ned_frd(quat_wxyz)))


def enu(vector: Vector3r) -> Vector3:
    """A vector of AirSim's world in the scene's axes."""
    return swap_enu_ned((vector.x_val, vector.y_val, vector.z_val))


def quat_enu_flu(quat: Quaternionr) -> Quaternion:
    """An attitude of AirSim's from FLU to ENU, normalised.

    Raises:
        RpcError: If it is no attitude.
    """
    wxyz = (quat.w_val, quat.x_val, quat.y_val, quat.z_val)
    norm = math.hypot(*wxyz)
    if not 1e-6 < norm < math.inf:
        raise RpcError(f"orientation {wxyz} is no attitude; valid: a quaternion that is not zero")
    w, x, y, z = (c / norm for c in wxyz)
    return swap_quat_enu_flu_ned_frd((w, x, y, z))


def geo(place: Geodetic) -> GeoPoint:
    """A place on the earth."""
    return GeoPoint(place.latitude_deg, place.longitude_deg, place.altitude_m)


def pose(position_enu_m: Vector3, quat_wxyz: Quaternion) -> Pose:
    """Position and attitude of the world."""
    return Pose(ned(position_enu_m), attitude(quat_wxyz))


def stamp(time_us: int) -> int:
    """Simulated time as nanoseconds of the Unix epoch, as the autopilot tells the date."""
    return 1000 * (EPOCH_US + time_us)


def floats(values: np.ndarray) -> msgspec.Raw:
    """An array of numbers as a list on the wire, four bytes and a header each."""
    flat = np.ascontiguousarray(values, dtype=">f4").reshape(-1)
    packed = np.empty(len(flat), dtype=[("head", "u1"), ("value", ">f4")])
    packed["head"], packed["value"] = 0xCA, flat
    return msgspec.Raw(struct.pack(">BI", 0xDD, len(flat)) + packed.tobytes())
