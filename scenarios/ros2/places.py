"""Messages of positions: satellite fixes, and landing areas as markers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from aeroscene.scene import InteractionArea
from flightsim.frames import LocalFrame
from flightsim.sensors.gnss_reading import GnssReading
from scenarios.ros2.messages import RosMessages

_NO_FIX, _FIX, _GROUND_BASED = -1, 0, 2
"""Values of sensor_msgs/NavSatStatus."""
_RTK_FLOAT, _FIX_3D = 5, 3
"""Values of MAVLink's GPS_FIX_TYPE."""
_GPS_SERVICE = 1
# Values of NavSatFix (covariance type) and of visualization_msgs/Marker (type and action).
_DIAGONAL_KNOWN, _LINE_STRIP, _ADD = 2, 4, 0
_AREA_RGBA = (0.2, 0.8, 0.3, 1.0)
_LINE_M = 0.05


def satellite_fix(ros: RosMessages, header: Any, reading: GnssReading, frame: LocalFrame) -> Any:
    """Return a sensor_msgs/NavSatFix of a receiver's reading.

    ROS asks for altitudes above the ellipsoid, but here they are above mean sea level, like those
    of the scene and of MAVLink.

    Args:
        ros: Maker of messages.
        header: Time and body frame.
        reading: Reading, whose accuracy becomes the covariance.
        frame: Local frame, by which the position is converted to degrees.
    """
    place = frame.geodetic_from_enu(reading.position_enu_m)
    is_fixed = reading.fix_type >= _FIX_3D
    status = _GROUND_BASED if reading.fix_type >= _RTK_FLOAT else _FIX
    across, upwards = (e * e if is_fixed else 0.0 for e in (reading.eph_m, reading.epv_m))
    return ros.new(
        "sensor_msgs/NavSatFix",
        header=header,
        status=ros.new(
            "sensor_msgs/NavSatStatus",
            status=status if is_fixed else _NO_FIX,
            service=_GPS_SERVICE,
        ),
        latitude=place.latitude_deg,
        longitude=place.longitude_deg,
        altitude=place.altitude_m,
        position_covariance=np.diag([across, across, upwards]).ravel(),
        position_covariance_type=_DIAGONAL_KNOWN if is_fixed else 0,
    )


def area_markers(ros: RosMessages, header: Any, areas: Sequence[InteractionArea]) -> Any:
    """Return a visualization_msgs/MarkerArray with the outline of each area.

    Args:
        ros: Maker of messages.
        header: Time and world frame.
        areas: Areas; a marker's namespace is its kind, and its id the number that `--area` takes.
    """
    markers = [_outline(ros, header, area) for area in areas]
    return ros.new("visualization_msgs/MarkerArray", markers=markers)


def _outline(ros: RosMessages, header: Any, area: InteractionArea) -> Any:
    ring = [*area.polygon, area.polygon[0]]  # closed, since a line strip is open
    nothing = ros.new("builtin_interfaces/Duration", sec=0, nanosec=0)
    r, g, b, a = _AREA_RGBA
    no_picture = ros.new("sensor_msgs/CompressedImage", **_empty_picture(header))
    return ros.new(
        "visualization_msgs/Marker",
        header=header,
        ns=area.kind,
        id=area.id,
        type=_LINE_STRIP,
        action=_ADD,
        pose=ros.pose((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)),
        scale=ros.vector((_LINE_M, 0.0, 0.0)),
        color=ros.new("std_msgs/ColorRGBA", r=r, g=g, b=b, a=a),
        lifetime=nothing,
        frame_locked=False,
        points=[ros.vector(corner, "Point") for corner in ring],
        colors=[],
        texture_resource="",
        texture=no_picture,
        uv_coordinates=[],
        text="",
        mesh_resource="",
        mesh_file=ros.new(
            "visualization_msgs/MeshFile", filename="", data=np.zeros(0, dtype=np.uint8)
        ),
        mesh_use_embedded_materials=False,
    )


def _empty_picture(header: Any) -> dict[str, Any]:
    return {"header": header, "format": "", "data": np.zeros(0, dtype=np.uint8)}
