"""Steps of a flight by offboard set points, as generators: each `yield` lasts one tick.

A flight is a sequence, but a pilot is called once a tick. Generators let the sequence be written
from top to bottom: the pilot's `update` calls `next`, and `yield from` joins steps.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator

import numpy as np

from aeroscene.scene import InteractionArea
from autonomy.types import FlatReference, Vector3, vector3
from flightsim.mavlink.client import PX4_LAND, PX4_OFFBOARD, MavlinkClient
from scenarios.run.companion import Aboard

TICK_S = 0.02
_REST_S = 1.0
"""Time at the end of a line in which the vehicle comes to rest."""


def area_of(aboard: Aboard) -> InteractionArea:
    """Return the assigned area, or else the roomiest one under open sky.

    Args:
        aboard: Equipment; its scene has at least one landing area.
    """
    # Clearance is capped where nothing is above, so areas under open sky share the greatest one.
    areas = aboard.scene.landing_areas
    return aboard.area or max(areas, key=lambda area: (area.clearance_m, area.radius))


def take_control(client: MavlinkClient) -> Generator[None, None, Vector3]:
    """Arm in offboard mode as soon as that is allowed.

    Args:
        client: Companion's client.

    Returns:
        Estimated position at the start, ENU.
    """
    state = client.telemetry
    client.request_streams()
    while not (state.has_state and state.is_armable and state.local_origin_enu_m):
        yield
    start = state.position_enu_m
    yield from fly_line(client, start, start, 1.0)  # Offboard mode wants setpoints first.
    client.set_mode(PX4_OFFBOARD)
    client.arm()
    return start


def fly_line(
    client: MavlinkClient, start_enu_m: Vector3, end_enu_m: Vector3, speed_mps: float
) -> Iterator[None]:
    """Send set points along a line, from rest to rest.

    Args:
        client: Companion's client, in offboard mode.
        start_enu_m: Present position.
        end_enu_m: End of the line.
        speed_mps: Greatest speed, in the middle of the line.
    """
    start, way = np.array(start_enu_m), np.subtract(end_enu_m, start_enu_m)
    # The smooth step is 1.5 times as fast in its middle as on average.
    n_ticks = math.ceil(1.5 * float(np.linalg.norm(way)) / speed_mps / TICK_S)
    for tick in range(n_ticks + round(_REST_S / TICK_S)):
        share = min(1.0, (tick + 1) / max(n_ticks, 1))
        at = start + share * share * (3.0 - 2.0 * share) * way
        client.send_setpoint(FlatReference(position_enu_m=vector3(at)))
        yield


def land(client: MavlinkClient) -> Iterator[None]:
    """Descend straight down in the autopilot's own landing mode, until it has disarmed.

    Args:
        client: Companion's client.
    """
    client.set_mode(PX4_LAND)
    # The autopilot disarms by itself once it has detected the ground.
    while client.telemetry.is_armed:
        yield
