"""Values that the kernel needs besides the plant's record: the autopilot's, and constants."""

from __future__ import annotations

import math
import struct
from collections.abc import Mapping, Sequence

import numpy as np

from autonomy.types import NAN3
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.streaming.readings import MAX_RANGE_CM, MIN_RANGE_CM
from flightsim.mavlink.streaming.record import VALUES_DTYPE, VIEW_DTYPE
from flightsim.mavlink.view import VehicleView

_AUTOPILOT_VALUES = struct.Struct("=q4d")
"""First fields of `VIEW_DTYPE`: the autopilot's values of each tick."""

_UNKNOWN_COVARIANCE = (math.nan, *(0.0,) * 20)  # NaN in the first element: unknown
_FIXED: Mapping[str, Mapping[str, float | Sequence[float]]] = {
    "ODOMETRY": {
        "pose_covariance": _UNKNOWN_COVARIANCE,
        "velocity_covariance": _UNKNOWN_COVARIANCE,
        "frame_id": mav.MAV_FRAME_LOCAL_NED,
        "child_frame_id": mav.MAV_FRAME_BODY_FRD,
        "estimator_type": mav.MAV_ESTIMATOR_TYPE_AUTOPILOT,
        "quality": 100,
    },
    "POSITION_TARGET_LOCAL_NED": {"coordinate_frame": mav.MAV_FRAME_LOCAL_NED},
    "POSITION_TARGET_GLOBAL_INT": {"coordinate_frame": mav.MAV_FRAME_GLOBAL_INT},
    "HIGHRES_IMU": {"fields_updated": 0x1FFF},
    "DISTANCE_SENSOR": {
        "min_distance": MIN_RANGE_CM,
        "max_distance": MAX_RANGE_CM,
        "type": mav.MAV_DISTANCE_SENSOR_LASER,
        "orientation": mav.MAV_SENSOR_ROTATION_PITCH_270,
        "covariance": 0xFF,  # unknown
    },
    "WIND_COV": {"horiz_accuracy": math.nan, "vert_accuracy": math.nan},
}
"""Fields that never change; fields that are missing here are 0."""


class KernelInputs:
    """Memory from which the kernel fills messages.

    Attributes:
        values: `VALUES_DTYPE` (1,).
        view: `VIEW_DTYPE` (1,).
        plant_address: Address of the plant's record.
    """

    def __init__(self, view: VehicleView) -> None:
        self._view = view
        self.plant_address = view.plant.record_address
        self.values = np.zeros(1, VALUES_DTYPE)
        for name, fixed in _FIXED.items():
            for field, value in fixed.items():
                self.values[0][name][field] = value
        self.view = np.zeros(1, VIEW_DTYPE)
        self._view_bytes = self.view.data.cast("B")
        record: np.void = self.view[0]
        frame, airframe = view.frame, view.plant.world.airframe
        for field in ("latitude_deg", "longitude_deg", "altitude_m"):
            record[field] = getattr(frame.origin, field)
        record["metres_per_degree_north"] = frame.metres_per_degree_north
        record["metres_per_degree_east"] = frame.metres_per_degree_east
        record["origin_enu_m"] = view.origin_enu_m
        record["n_motors"] = len(airframe.motors)
        record["motors"][: len(airframe.motors)] = airframe.motors
        record["most_radps"] = max(r.max_speed_radps for r in airframe.quadrotor.rotors)

    def listen(self) -> None:
        """Write the autopilot's values of this tick into the record."""
        autopilot, target = self._view.autopilot, self._view.autopilot.target_enu_m or NAN3
        _AUTOPILOT_VALUES.pack_into(
            self._view_bytes, 0, autopilot.is_armed, self._view.home_altitude_m, *target
        )
