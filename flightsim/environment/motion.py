"""Motion of movers along their paths: one compiled call per control tick.

A mover on a loop circulates at its speed. One that goes to and fro accelerates and brakes evenly,
and rests at each end, where a person turns round. Its place depends on the traffic's clock alone,
so that a run repeats and any time can be computed at once. That clock is simulated time, but may
run faster or slower, or stop, and its rate changes gradually.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from autonomy.jit import fields, kernel
from flightsim.environment.movers import MOVER_KINDS, MoverName, MovingObstacle, ObstacleStates
from flightsim.environment.paths import smooth_path

MAX_RATE = 5.0
_RATE_CHANGE_PER_S = 1.0  # a change of pace takes a second, so that no mover jumps to another speed
_CONTACT_MARGIN_M = 2.0  # covers the vehicle's extent and the motion of a tick
_STRAIGHT_UP = 1e-9  # a path that leads straight up has no heading

TRAFFIC_DTYPE = np.dtype(fields("clock_s", "rate", "rate_cmd", "dt_s"))
"""Clock shared by all movers."""

MOVER_DTYPE = np.dtype(
    [
        ("first", "i8"),  # of its control points
        *fields("n_points", "is_loop", "turns_round", "body", "geom", "contact_bits", kind="i8"),
        *fields("spacing_m", "length_m", "speed_mps", "acceleration_mps2", "pause_s", "phase_s"),
        *fields("radius_m", "height_m", "distance_m", "distance_rate_mps", "yaw_rad"),
        ("turn", "f8"),  # half turns that it made at the ends of its path
        ("position_enu_m", "f8", 3),  # middle of its underside
        *fields("velocity_enu_mps", "tangent", shape=(3,)),
    ],
    align=True,
)


def new_traffic(dt_s: float) -> np.ndarray:
    """Return a clock at zero, in an array of shape (1,), for ticks of `dt_s`."""
    traffic = np.zeros(1, TRAFFIC_DTYPE)
    traffic["rate"] = traffic["rate_cmd"] = 1.0
    traffic["dt_s"] = dt_s
    return traffic


def new_movers(obstacles: Sequence[MovingObstacle]) -> tuple[np.ndarray, np.ndarray]:
    """Return records of movers, (n,), and the control points of all their paths, (k, 3).

    Args:
        obstacles: The movers; each has its own stretch of the control points.
    """
    movers = np.zeros(len(obstacles), MOVER_DTYPE)
    points = [np.zeros((0, 3))]
    first = 0
    for mover, obstacle in zip(movers, obstacles, strict=True):
        path = smooth_path(obstacle.path_enu_m, is_loop=obstacle.is_loop)
        kind = MOVER_KINDS[obstacle.kind]
        speed = obstacle.speed_mps
        if not obstacle.is_loop:
            # A short path limits the speed that is reached.
            speed = min(speed, math.sqrt(path.length_m * kind.acceleration_mps2))
        for name in ("turns_round", "acceleration_mps2", "pause_s", "radius_m"):
            mover[name] = getattr(kind, name)
        for name in ("spacing_m", "length_m", "is_loop"):
            mover[name] = getattr(path, name)
        mover["first"], mover["n_points"] = first, len(path.points_enu_m)
        mover["speed_mps"], mover["height_m"] = speed, kind.size_m[2]
        # Trapezoid of speed: its ramps add v / a to the time at full speed.
        one_way_s = path.length_m / speed + speed / kind.acceleration_mps2 + kind.pause_s
        period_s = path.length_m / speed if obstacle.is_loop else 2.0 * one_way_s
        mover["phase_s"] = obstacle.phase * period_s
        points.append(path.points_enu_m)
        first += len(path.points_enu_m)
    return movers, np.ascontiguousarray(np.concatenate(points))


def start_poses(obstacles: Sequence[MovingObstacle]) -> tuple[np.ndarray, np.ndarray]:
    """Return positions (n, 3) and attitudes wxyz (n, 4) of movers at time zero."""
    movers, points = new_movers(obstacles)
    for mover in movers:
        place_mover(mover, points, 0.0, 1.0)
    half = movers["yaw_rad"] / 2
    zero = np.zeros_like(half)
    quat_wxyz = np.column_stack([np.cos(half), zero, zero, np.sin(half)])
    return movers["position_enu_m"].copy(), quat_wxyz


def obstacle_states(obstacles: Sequence[MovingObstacle], movers: np.ndarray) -> ObstacleStates:
    """Return the true states of obstacles, from the records of their movers.

    Args:
        obstacles: The movers, for their kinds and sizes.
        movers: `MOVER_DTYPE` (n,), of the same order.
    """
    kinds: tuple[MoverName, ...] = tuple(obstacle.kind for obstacle in obstacles)
    size_m = np.array([MOVER_KINDS[kind].size_m for kind in kinds]).reshape(-1, 3)
    return ObstacleStates(
        kinds=kinds,
        position_enu_m=movers["position_enu_m"] + size_m * (0.0, 0.0, 0.5),
        velocity_enu_mps=movers["velocity_enu_mps"].copy(),
        yaw_rad=movers["yaw_rad"].copy(),
        size_m=size_m,
    )


@kernel
def move_traffic(
    traffic: np.record,
    movers: np.ndarray,
    points: np.ndarray,
    mocap_pos: np.ndarray,
    mocap_quat: np.ndarray,
    geom_conaffinity: np.ndarray,
    body_conaffinity: np.ndarray,
) -> None:
    """Advance the clock by a tick and place every mover, with its contacts off (see `let_touch`).

    Args:
        traffic: Record of `TRAFFIC_DTYPE`, changed.
        movers: Records of `MOVER_DTYPE` (n,), changed.
        points: Control points of all paths (k, 3).
        mocap_pos: MuJoCo's positions (n, 3), written.
        mocap_quat: MuJoCo's attitudes (n, 4), written.
        geom_conaffinity: The model's array, written for the movers' geoms.
        body_conaffinity: The model's array, written for the movers' bodies.
    """
    change = traffic.rate_cmd - traffic.rate
    limit = _RATE_CHANGE_PER_S * traffic.dt_s
    traffic.rate += min(max(change, -limit), limit)
    traffic.clock_s += traffic.rate * traffic.dt_s
    for i in range(len(movers)):
        m = movers[i]
        place_mover(m, points, traffic.clock_s, traffic.rate)
        for k in range(3):
            mocap_pos[i, k] = m.position_enu_m[k]
        mocap_quat[i, 0], mocap_quat[i, 3] = math.cos(0.5 * m.yaw_rad), math.sin(0.5 * m.yaw_rad)
        geom_conaffinity[m.geom] = body_conaffinity[m.body] = 0


@kernel
def let_touch(
    movers: np.ndarray,
    vehicle_enu_m: np.ndarray,
    geom_conaffinity: np.ndarray,
    body_conaffinity: np.ndarray,
) -> bool:
    """Enable the contacts of movers near a vehicle; return true if there is such a mover.

    Contacts of movers far from every vehicle stay disabled: checking them would cost a third of a
    physics step.

    Args:
        movers: Records of `MOVER_DTYPE` (n,) in their places.
        vehicle_enu_m: Position of the vehicle (3,).
        geom_conaffinity: The model's array, written for the movers' geoms.
        body_conaffinity: The model's array, written for the movers' bodies.
    """
    is_near = False
    for i in range(len(movers)):
        m = movers[i]
        gap_squared = 0.0
        for k in range(3):
            # Positions are of the underside; the sphere is around the middle.
            lift = 0.5 * m.height_m if k == 2 else 0.0
            gap_squared += (m.position_enu_m[k] + lift - vehicle_enu_m[k]) ** 2
        if gap_squared < (m.radius_m + _CONTACT_MARGIN_M) ** 2:
            geom_conaffinity[m.geom] = body_conaffinity[m.body] = m.contact_bits
            is_near = True
    return is_near


@kernel
def place_mover(m: np.record, points: np.ndarray, clock_s: float, rate: float) -> None:
    """Compute the pose and velocity of one mover.

    Args:
        m: Record of `MOVER_DTYPE`, changed.
        points: Control points of all paths (k, 3).
        clock_s: Time of the traffic's clock.
        rate: Rate of that clock relative to simulated time.
    """
    time_s = clock_s + m.phase_s
    if m.is_loop == 1:
        m.distance_m, m.distance_rate_mps = (m.speed_mps * time_s) % m.length_m, m.speed_mps
    else:
        _go_to_and_fro(m, time_s)
    _follow_path(m, points)
    for k in range(3):
        m.velocity_enu_mps[k] = m.tangent[k] * m.distance_rate_mps * rate
    if m.tangent[0] ** 2 + m.tangent[1] ** 2 > _STRAIGHT_UP:
        m.yaw_rad = math.atan2(m.tangent[1], m.tangent[0])
        if m.turns_round == 1:
            m.yaw_rad += math.pi * m.turn


@kernel
def _go_to_and_fro(m: np.record, time_s: float) -> None:
    """Move along the path with trapezoidal speed and rests at the ends."""
    ramp_s = m.speed_mps / m.acceleration_mps2
    moving_s = m.length_m / m.speed_mps + ramp_s
    one_way_s = moving_s + m.pause_s
    since = time_s % (2.0 * one_way_s)
    is_back = since >= one_way_s
    if is_back:
        since -= one_way_s
    if since >= moving_s:
        distance, speed = m.length_m, 0.0
        share = (since - moving_s) / m.pause_s
        # Smooth step of the turn on the spot, 0 to 1 during the pause.
        m.turn = share * share * (3.0 - 2.0 * share)
    else:
        m.turn = 0.0
        left = moving_s - since
        if since < ramp_s:
            speed = m.acceleration_mps2 * since
            distance = 0.5 * speed * since
        elif left < ramp_s:
            speed = m.acceleration_mps2 * left
            distance = m.length_m - 0.5 * speed * left
        else:
            speed = m.speed_mps
            distance = m.speed_mps * (since - 0.5 * ramp_s)
    if is_back:
        m.turn += 1.0
        distance, speed = m.length_m - distance, -speed
    m.distance_m, m.distance_rate_mps = distance, speed


@kernel
def _follow_path(m: np.record, points: np.ndarray) -> None:
    """Evaluate position and derivative by distance at `distance_m`."""
    u = m.distance_m / m.spacing_m
    i = int(u)
    if m.is_loop == 0:
        i = min(max(i, 0), m.n_points - 4)
    t = u - i
    s = 1.0 - t
    # Weights of the uniform cubic B-spline at t, and below their derivatives.
    a, d = s * s * s / 6.0, t * t * t / 6.0
    b = ((3.0 * t - 6.0) * t * t + 4.0) / 6.0
    c = 1.0 - a - b - d
    da, dd = -0.5 * s * s, 0.5 * t * t
    db = (1.5 * t - 2.0) * t
    dc = -da - db - dd
    n = m.n_points
    # On a loop the control points repeat.
    w, x, y, z = i % n, (i + 1) % n, (i + 2) % n, (i + 3) % n
    for k in range(3):
        p, q = points[m.first + w, k], points[m.first + x, k]
        r, o = points[m.first + y, k], points[m.first + z, k]
        m.position_enu_m[k] = a * p + b * q + c * r + d * o
        m.tangent[k] = (da * p + db * q + dc * r + dd * o) / m.spacing_m
