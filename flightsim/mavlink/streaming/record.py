"""Records of the streaming kernel: messages, partners and the vehicle.

Values of a compiled message are written as doubles, by the names of its fields, into
`VALUES_DTYPE`. Their order on the wire and their types are those of the dialect's message classes,
so that a filling function never deals with bytes.

Another message is compiled in three steps: add its name to a group of `_TOGETHER`; fill its fields
and `is_known` in the function of that group, which `kernel._fill` calls (it lies in `motion.py`,
`navigation.py` or `readings.py`); and give its constant fields their values in `inputs.py`.
"""

from __future__ import annotations

import numpy as np

from autonomy.jit import fields
from flightsim.mavlink.dialect import LAYOUTS, Layout
from flightsim.mavlink.streaming.packing import TYPES

_TOGETHER = (
    ("ATTITUDE", "ATTITUDE_QUATERNION", "LOCAL_POSITION_NED", "GLOBAL_POSITION_INT", "ODOMETRY"),
    ("HIGHRES_IMU",),
    (
        *("ATTITUDE_TARGET", "VFR_HUD", "ALTITUDE", "POSITION_TARGET_LOCAL_NED"),
        *("POSITION_TARGET_GLOBAL_INT", "NAV_CONTROLLER_OUTPUT", "HIL_STATE_QUATERNION"),
    ),
    ("DISTANCE_SENSOR", "SERVO_OUTPUT_RAW", "SCALED_PRESSURE"),
    ("GPS_RAW_INT", "ESTIMATOR_STATUS", "WIND_COV", "VIBRATION", "SYSTEM_TIME"),
)
POSE, IMU, COURSE, READINGS, NAVIGATION = range(len(_TOGETHER))
"""Groups of messages that are filled together, when the first of them is due in a tick."""

KERNEL_MESSAGES = tuple(name for group in _TOGETHER for name in group)
"""Messages that the kernel fills: those that companions get ten times a second and more, and those
that are nothing but numbers of the plant's record."""

MOST_PARTS = 4
"""Most messages of one type in a tick, such as ESC_STATUS of sixteen motors."""
MOST_MOTORS = 16


def _values_dtype(message: Layout) -> np.dtype:
    """Return the type of a message's values in wire order, behind a flag that there are any."""
    counts = message.counts.items()
    shaped = [(name, "f8", (n,)) if n > 1 else (name, "f8") for name, n in counts]
    return np.dtype([("is_known", "f8"), *shaped])


VALUES_DTYPE = np.dtype([(name, _values_dtype(LAYOUTS[name])) for name in KERNEL_MESSAGES])
"""Present values of each of `KERNEL_MESSAGES`."""

MESSAGE_DTYPE = np.dtype(
    [
        *fields("message_id", "size", "crc_seed", kind="i8"),
        ("payload_start", "i8"),  # of its parts among all payloads
        ("n_parts", "i8"),  # 0 where there is nothing to tell
        ("packed_us", "i8"),  # time of which they tell
        ("first_value", "i8"),  # among those of `VALUES_DTYPE`; negative if Python packs it
        ("n_values", "i8"),
        ("group", "i8"),  # of those that are filled together
    ]
)
"""A type of message that can be streamed."""

PARTNER_DTYPE = np.dtype(
    fields(
        *("service_mode", "sequence", "n_frames", "n_bytes"),
        *("now_us", "system_id", "component_id"),
        *("next_address", "interval_address", "due_address", "frames_address"),
        kind="i8",
    )
)
"""A partner: how it is served, and the addresses of its calendar and its frames."""

WAITS, FRAMED, ONE_BY_ONE = range(3)
"""Ways to serve a partner in a tick.

`WAITS`: its transport lags behind, so nothing is sent until it has caught up. `FRAMED`: the kernel
writes plain MAVLink 2 frames. `ONE_BY_ONE`: Python frames each message by itself, because the
partner speaks MAVLink 1 or wants signatures."""

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
        *("plant_address", "view_address", "values_address", "types_address"),
        *("messages_address", "partners_address", "wanted_address", "payloads_address"),
        *("n_messages", "n_partners", "filled_us", "filled", "next_us"),
        kind="i8",
    )
)
"""Addresses of all these records. `partners_address` holds addresses, one for each partner,
`filled` has a bit for each group that is filled as of `filled_us`, and `next_us` is the time at
which a message is due for one of the partners again."""


_FIRST_VALUES = {
    name: offset // 8 + 1 for name, (_, offset, *_) in (VALUES_DTYPE.fields or {}).items()
}
"""Index of the first value of each of `KERNEL_MESSAGES` among all doubles, behind `is_known`."""


def message_rows(layouts: list[Layout]) -> np.ndarray:
    """Return `MESSAGE_DTYPE` rows of these types, each with room for its parts."""
    rows = np.zeros(len(layouts), MESSAGE_DTYPE)
    start = 0
    for row, layout in zip(rows, layouts, strict=True):
        row["message_id"], row["size"] = layout.message_id, layout.size
        row["crc_seed"] = layout.crc_seed[0]
        row["payload_start"], row["packed_us"] = start, -1  # nothing is packed yet
        row["first_value"] = -1
        if layout.name in KERNEL_MESSAGES:
            row["first_value"] = _FIRST_VALUES[layout.name]
            row["n_values"] = len(layout.letters)
            row["group"] = next(k for k, names in enumerate(_TOGETHER) if layout.name in names)
        start += MOST_PARTS * layout.size
    return rows


def value_types() -> np.ndarray:
    """Return the index in `TYPES` of the type on the wire of each double in `VALUES_DTYPE`."""
    types = np.zeros(VALUES_DTYPE.itemsize // 8, np.uint8)
    for name, first in _FIRST_VALUES.items():
        for index, letter in enumerate(LAYOUTS[name].letters, start=first):
            types[index] = TYPES.index(letter)
    return types
