"""OBSTACLE_DISTANCE of the vehicle's own ring scan, for clients and for other flight stacks."""

from __future__ import annotations

from autonomy.types import yaw_of
from flightsim.lidars.ring_scanner import MAX_RANGE_M, MIN_RANGE_M, N_BEAMS, RingScanner
from flightsim.mavlink.dialect import dialect as mav
from flightsim.mavlink.dialect import layout
from flightsim.plant import Plant

OBSTACLE_DISTANCE = layout("OBSTACLE_DISTANCE")
_NONE_CM = round(100.0 * MAX_RANGE_M) + 1
"""Value for a beam that meets nothing: the range plus one, as MAVLink defines."""


class RingReport:
    """Distances to the nearest solid in each of 72 level directions, clockwise from the nose."""

    def __init__(self, plant: Plant) -> None:
        self._plant = plant
        self._scanner = RingScanner(plant.world, plant.data)

    def payload(self, time_us: int) -> bytes:
        """Return the payload of OBSTACLE_DISTANCE for a scan from the vehicle's true place.

        Args:
            time_us: Simulated time of the report.
        """
        truth = self._plant.truth
        ranges_m = self._scanner.scan_m(truth.position_enu_m, yaw_of(truth.quat_wxyz))
        return OBSTACLE_DISTANCE.encode(
            time_usec=time_us,
            sensor_type=mav.MAV_DISTANCE_SENSOR_LASER,
            distances=[round(100.0 * r) if r < MAX_RANGE_M else _NONE_CM for r in ranges_m],
            increment=360 // N_BEAMS,
            increment_f=360.0 / N_BEAMS,
            min_distance=round(100.0 * MIN_RANGE_M),
            max_distance=_NONE_CM - 1,
            frame=mav.MAV_FRAME_BODY_FRD,
        )
