"""Records of the kernel that streams: what it knows of messages, of partners and of the vehicle.

What a compiled message tells is written as doubles, by the names of its fields, into
`VALUES_DTYPE`. Their order on the wire and their types are those of the dialect's message classes.
"""

from __future__ import annotations

import numpy as np

from autonomy.jit import fields
from flightsim.mavlink.dialect import LAYOUTS, Layout, number_range

TOLD = (
    *("ATTITUDE", "ATTITUDE_QUATERNION", "ATTITUDE_TARGET", "LOCAL_POSITION_NED"),
    *("GLOBAL_POSITION_INT", "ODOMETRY", "VFR_HUD", "ALTITUDE", "POSITION_TARGET_LOCAL_NED"),
    *("POSITION_TARGET_GLOBAL_INT", "NAV_CONTROLLER_OUTPUT", "HIL_STATE_QUATERNION"),
    *("HIGHRES_IMU", "DISTANCE_SENSOR", "SERVO_OUTPUT_RAW", "GPS_RAW_INT", "SCALED_PRESSURE"),
    *("ESTIMATOR_STATUS", "WIND_COV", "VIBRATION", "SYSTEM_TIME"),
)
"""Messages that the kernel fills: those that companions get ten times a second and more, and those
that are nothing but numbers of the plant's record."""

MOST_PARTS = 4
"""Most messages of one type in a tick, such as ESC_STATUS of sixteen motors."""
MOST_MOTORS = 16


def _values_dtype(message: Layout) -> np.dtype:
    """Values of a message in wire order, after whether there is anything to tell."""
    counts = message.counts.items()
    shaped = [(name, "f8", (n,)) if n > 1 else (name, "f8") for name, n in counts]
    return np.dtype([("is_known", "f8"), *shaped])


VALUES_DTYPE = np.dtype([(name, _values_dtype(LAYOUTS[name])) for name in TOLD])
"""What each of `TOLD` says now."""

FIELD_DTYPE = np.dtype([("size", "i8"), ("is_float", "i8"), *fields("least", "most")])
"""Type on the wire of one of the doubles: its bytes, and the range of its numbers."""

MESSAGE_DTYPE = np.dtype(
    [
        *fields("message_id", "size", "crc_seed", kind="i8"),
        ("payload_start", "i8"),  # of its parts among all payloads
        ("n_parts", "i8"),  # 0 where there is nothing to tell
        ("packed_us", "i8"),  # time of which they tell
        ("first_value", "i8"),  # among those of `VALUES_DTYPE`; negative if Python packs it
        ("n_values", "i8"),
    ]
)
"""A type of message that can be streamed."""

PARTNER_DTYPE = np.dtype(
    fields(
        *("way", "sequence", "n_frames", "n_bytes"),
        *("now_us", "system_id", "component_id"),
        *("next_address", "interval_address", "due_address", "frames_address"),
        kind="i8",
    )
)
"""A partner: how it is served, and where its calendar and its frames are."""

WAITS, FRAMED, ONE_BY_ONE = range(3)
"""Ways to serve a partner: not in this tick, with MAVLink 2 frames, or as Python does it."""

VIEW_DTYPE = np.dtype(
    [
        # What the autopilot says in this tick, in the order in which it is written.
        ("is_armed", "i8"),
        ("home_altitude_m", "f8"),
        ("target_enu_m", "f8", 3),  # NaN without one
        # The place of the scene, and the origin of MAVLink's local frame.
        *fields("latitude_deg", "longitude_deg", "altitude_m"),
        *fields("metres_per_degree_north", "metres_per_degree_east"),
        ("origin_enu_m", "f8", 3),
        # Motors in the order of their numbers.
        ("n_motors", "i8"),
        ("motors", "i8", MOST_MOTORS),
        ("most_radps", "f8"),
        # The estimate in MAVLink's frames, converted once a tick.
        *fields("time_us", "time_boot_ms", "altitude_est_m", "latitude_est_deg"),
        *fields("longitude_est_deg", "heading_deg"),
        *fields("position_ned_m", "velocity_ned_mps", "rpy_rad", "rates_frd_radps", shape=(3,)),
        ("quat_ned_frd", "f8", 4),
    ],
    align=True,
)
"""The vehicle as `flightsim.mavlink.view.VehicleView` sees it, for kernels."""

STREAMER_DTYPE = np.dtype(
    fields(
        *("plant_address", "view_address", "values_address", "fields_address"),
        *("messages_address", "partners_address", "wanted_address", "payloads_address"),
        *("n_messages", "n_partners", "filled_us", "next_us"),
        kind="i8",
    )
)
"""Where all that is. `partners_address` is of addresses, one for each partner, and `next_us` the
time at which something is due for one of them again."""


_FIRST_VALUES = {
    name: offset // 8 + 1 for name, (_, offset, *_) in (VALUES_DTYPE.fields or {}).items()
}
"""Index of the first value of each of `TOLD` among all doubles, behind whether it is known."""


def message_rows(layouts: list[Layout]) -> np.ndarray:
    """`MESSAGE_DTYPE` of messages of these types, each with room for its parts."""
    rows = np.zeros(len(layouts), MESSAGE_DTYPE)
    start = 0
    for row, layout in zip(rows, layouts, strict=True):
        row["message_id"], row["size"] = layout.message_id, layout.size
        row["crc_seed"] = layout.crc_seed[0]
        row["payload_start"], row["packed_us"] = start, -1
        row["first_value"] = -1
        if layout.name in TOLD:
            row["first_value"] = _FIRST_VALUES[layout.name]
            row["n_values"] = len(layout.letters)
        start += MOST_PARTS * layout.size
    return rows


def field_rows() -> np.ndarray:
    """`FIELD_DTYPE` of each double in `VALUES_DTYPE`."""
    rows = np.zeros(VALUES_DTYPE.itemsize // 8, FIELD_DTYPE)
    for name, first in _FIRST_VALUES.items():
        for index, letter in enumerate(LAYOUTS[name].letters, start=first):
            least, most = number_range(letter)
            rows[index] = (np.dtype(letter).itemsize, letter == "f", least, most)
    return rows
