"""Short flights that exercise the estimator: take-off, then curves or a visit to a room.

Curves excite all axes, so that biases become observable. The room takes away the satellites for a
while, which is when position errors grow.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from aeroscene.scene import OrientedBox, Scene, SceneObject
from aeroscene.scene.catalogue import category_id
from autonomy.types import IDLE, OFF, ControlLevel, Setpoint, Vector3, vector3
from flightsim.plant import Plant
from flightsim.plant.cfg import ADVANCE_HZ

REST_S = 2.0
TAKE_OFF_S = 4.0
HEIGHT_M = 3.0
_IDLE_S = 0.5
_RAMP_S = 4.0
_ROOM_M = (16.0, 10.0, 6.0)
_ROOM_EAST_M = 18.0
_CRUISE_MPS = 1.5

Path = Callable[[float], Setpoint]
"""Function from the time since the end of the take-off, s, to a setpoint."""


def meadow(*, has_room: bool, start_enu_m: Vector3 = (0.0, 0.0, 0.0)) -> Scene:
    """Return a scene of level, empty ground, optionally with one room 10 m east of its middle.

    Args:
        has_room: True adds the room, which is 16 m long, 10 m wide and 6 m high.
        start_enu_m: Start of the vehicle.
    """
    scene_id = "meadow"
    box = OrientedBox(p=(_ROOM_EAST_M, 0.0, _ROOM_M[2] / 2), q=(1.0, 0.0, 0.0, 0.0), s=_ROOM_M)
    room = SceneObject(
        id=1,
        scene_id=scene_id,
        domain="outdoor",
        category_id=category_id("room"),
        parent_id=None,
        bbox=box,
    )
    return Scene(
        scene_id=scene_id,
        domain="outdoor",
        seed=0,
        extent_min_enu_m=(-50.0, -50.0, 0.0),
        extent_max_enu_m=(50.0, 50.0, 40.0),
        start_position_enu_m=start_enu_m,
        start_yaw_rad=0.0,
        latitude_deg=47.4,
        longitude_deg=8.5,
        altitude_m=488.0,
        objects=(room,) if has_room else (),
    )


def curves(rng: np.random.Generator) -> Path:
    """Return a Lissajous figure of up to 6 m/s and 5 m/s^2 around the start, with a swinging nose.

    Args:
        rng: Source of its extents, rates and yaw.
    """
    reach = rng.uniform((5.0, 4.0, 0.5), (9.0, 8.0, 1.2))
    pace = rng.uniform((0.35, 0.35, 0.3), (0.6, 0.6, 0.8))
    swing = rng.uniform(0.3, 1.2)
    yaw = rng.uniform(-math.pi, math.pi)

    def setpoint(time_s: float) -> Setpoint:
        # Phase s with s' rising from 0 to 1 over the ramp.
        is_ramp = time_s < _RAMP_S
        s = 0.5 * time_s**2 / _RAMP_S if is_ramp else time_s - 0.5 * _RAMP_S
        ds, dds = (time_s / _RAMP_S, 1.0 / _RAMP_S) if is_ramp else (1.0, 0.0)
        sines, cosines = np.sin(pace * s), np.cos(pace * s)
        # The last term climbs by two metres in the long run, and 10 / (s + 5)^2 is its rate.
        position = reach * sines + (0.0, 0.0, HEIGHT_M + 2.0 * s / (s + 5.0))
        velocity = reach * pace * cosines * ds + (0.0, 0.0, 10.0 / (s + 5.0) ** 2 * ds)
        acceleration = reach * pace * (cosines * dds - pace * sines * ds**2)
        return Setpoint(
            level=ControlLevel.TRAJECTORY,
            position_enu_m=vector3(position),
            velocity_enu_mps=vector3(velocity),
            acceleration_enu_mps2=vector3(acceleration),
            yaw_rad=yaw + swing * math.sin(0.5 * s),
        )

    return setpoint


def visit(rng: np.random.Generator) -> Path:
    """Return a visit to the room of `meadow`: in, around and out again.

    Args:
        rng: Source of shifts of the corners by up to half a metre.
    """
    corners = np.array(
        [(0, 0), (12, 0), (23, 3), (23, -3), (13, -3), (13, 3), (22, 0), (8, 0), (0, 0)],
        dtype=float,
    )
    # Start and end stay, since the vehicle takes off and ends there.
    corners[1:-1] += rng.uniform(-0.5, 0.5, (len(corners) - 2, 2))
    legs = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    arrival = np.concatenate([[0.0], np.cumsum(legs)]) / _CRUISE_MPS

    def setpoint(time_s: float) -> Setpoint:
        # Straight legs at a constant speed; after the last one the end is held.
        x, y = (float(np.interp(time_s, arrival, corners[:, axis])) for axis in (0, 1))
        return Setpoint(level=ControlLevel.TRAJECTORY, position_enu_m=(x, y, HEIGHT_M), yaw_rad=0.0)

    return setpoint


def fly(plant: Plant, path: Path, seconds: float) -> Iterator[float]:
    """Rest, take off, then follow a path.

    Args:
        plant: Plant at rest at its start.
        path: Path to fly.
        seconds: Duration of the path.

    Yields:
        Time since the take-off, s, after every 20 ms of the path.
    """
    start = plant.truth.position_enu_m
    above: Vector3 = (start[0], start[1], HEIGHT_M)
    hover = Setpoint(level=ControlLevel.TRAJECTORY, position_enu_m=above)
    for setpoint, duration_s in ((OFF, REST_S), (IDLE, _IDLE_S), (hover, TAKE_OFF_S)):
        plant.apply(setpoint)
        for _ in range(round(duration_s * ADVANCE_HZ)):
            plant.advance()
    for k in range(round(seconds * ADVANCE_HZ)):
        plant.apply(path(k / ADVANCE_HZ))
        plant.advance()
        yield (k + 1) / ADVANCE_HZ
