"""Movers on drawn paths as a passing vehicle's depth camera sees them, and how tracked."""

import math
from contextlib import closing
from dataclasses import dataclass

import numpy as np

from autonomy.perception import DepthImage, MoverTracker
from autonomy.rotation import matrix_from_quat, quat_from_rotation_vector
from flightsim.cameras import depth_noise, open_camera_renderer
from flightsim.environment.motion import new_movers, place_mover
from flightsim.environment.movers import MOVER_KINDS, MovingObstacle
from flightsim.vehicles.catalogue import AIRFRAMES
from flightsim.world import build_world
from tests.flightsim.handmade import empty_scene

PERIOD_S = 0.2
N_IMAGES = 60
IN_VIEW_S, WITHIN_M, NEAR_OUTLINE_M = 0.6, 9.0, 1.2
POSE_SIGMA_M, POSE_SIGMA_RAD, POSE_DRIFT_S = 0.05, math.radians(0.12), 2.0
"""Of each axis, 0.09 m and 0.2 degrees together, and how slowly they wander."""
LEAST_GAP_M = 3.5
_HALF_VIEW = 0.6


@dataclass(frozen=True, kw_only=True, eq=False)
class Look:
    """One image as the vehicle has it, and the truth."""

    time_s: float
    image: DepthImage
    off_m: np.ndarray
    position_enu_m: np.ndarray
    velocity_enu_mps: np.ndarray
    yaw_rad: float
    half_m: np.ndarray
    is_in_view: bool


def drawn_path(kind, rng):
    """A mover: half of them to and fro along a line, half round corners, as traffic has them."""
    low, high = MOVER_KINDS[kind].speed_mps
    length_m = {"person": 10.0, "car": 24.0, "drone": 14.0}[kind] * rng.uniform(0.7, 1.4)
    height_m = rng.uniform(1.5, 3.0) if kind == "drone" else 0.02
    heading, bend = rng.uniform(-math.pi, math.pi), rng.choice([0.0, 0.0, 0.9, -0.9, 1.5, -1.5])
    radius_m = 5.0 if kind == "car" else 0.6
    n = 24
    arc_m = radius_m * abs(bend)
    along = np.linspace(-length_m / 2, length_m / 2, n)
    turn = np.clip((along + arc_m / 2) / max(arc_m, 1e-9), 0.0, 1.0) * bend + heading
    steps = np.column_stack([np.cos(turn), np.sin(turn)]) * (length_m / n)
    path = np.cumsum(steps, axis=0)
    path -= path.mean(axis=0)
    points = tuple((float(x), float(y), height_m) for x, y in path)
    return MovingObstacle(
        kind=kind, path_enu_m=points, speed_mps=rng.uniform(low, high), phase=rng.uniform()
    )


def draw(kind, camera, seed, *, gazes=False):
    """Images of one mover in the open from a vehicle that passes.

    It looks at the mover or, where it gazes, at the middle of the path that the mover crosses.
    """
    rng = np.random.default_rng([seed, *kind.encode()])
    mover = drawn_path(kind, rng)
    world = build_world(empty_scene(start=(30.0, 30.0, 0.0)), AIRFRAMES["iris"], traffic=[mover])
    data, noise = world.new_data(), depth_noise(camera, seed, world.scene.scene_id)
    movers, points = new_movers([mover])
    size = np.array(MOVER_KINDS[kind].size_m)
    eye, drift = _passing_by(mover, rng)
    aside = rng.uniform(-0.25, 0.25)
    off_m, off_rad, keep = np.zeros(3), np.zeros(3), math.exp(-PERIOD_S / POSE_DRIFT_S)
    looks, yaw = [], None
    with closing(open_camera_renderer(world, 320, 240)) as renderer:
        for k in range(N_IMAGES):
            time_s = k * PERIOD_S
            place_mover(movers[0], points, time_s, 1.0)
            m = movers[0]
            centre = m["position_enu_m"] + size * (0, 0, 0.5)
            # To and fro beside it, at 3 s a way.
            here = eye + drift * (3.0 * abs(time_s / 3.0 % 2.0 - 1.0) - 1.5)
            there = np.zeros(2) if gazes else centre
            wished = math.atan2(there[1] - here[1], there[0] - here[0]) + aside
            yaw = (
                wished
                if yaw is None
                else yaw + np.clip((wished - yaw + math.pi) % (2 * math.pi) - math.pi, -0.3, 0.3)
            )
            data.qpos[:3] = here
            data.qpos[3:7] = (math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2))
            data.mocap_pos[0] = m["position_enu_m"]
            data.mocap_quat[0] = (math.cos(m["yaw_rad"] / 2), 0, 0, math.sin(m["yaw_rad"] / 2))
            frame = renderer.render_depth(data, "forward", round(time_s * 1e6))
            frame = frame if noise is None else noise.frame(frame)
            off_m = keep * off_m + math.sqrt(1 - keep**2) * POSE_SIGMA_M * rng.normal(size=3)
            off_rad = keep * off_rad + math.sqrt(1 - keep**2) * POSE_SIGMA_RAD * rng.normal(size=3)
            gap = centre - frame.position_enu_m
            angle = (math.atan2(gap[1], gap[0]) - yaw + math.pi) % (2 * math.pi) - math.pi
            looks.append(
                Look(
                    time_s=time_s,
                    image=_posed(frame, off_m, off_rad),
                    off_m=off_m.copy(),
                    position_enu_m=centre.copy(),
                    velocity_enu_mps=m["velocity_enu_mps"].copy(),
                    yaw_rad=float(m["yaw_rad"]),
                    half_m=size / 2,
                    is_in_view=abs(angle) < _HALF_VIEW and float(np.hypot(*gap[:2])) < WITHIN_M,
                )
            )
    return looks


def _passing_by(mover, rng):
    """Where a vehicle is in the middle of its way to and fro, and its velocity: never too near."""
    path = np.array(mover.path_enu_m)[:, :2]
    while True:
        bearing, away_m = rng.uniform(-math.pi, math.pi), rng.uniform(6.0, 9.0)
        eye = away_m * np.array([math.cos(bearing), math.sin(bearing)])
        drift = rng.uniform(0.5, 2.0) * np.array([-math.sin(bearing), math.cos(bearing)])
        ends = eye + np.linspace(-1.5, 1.5, 7)[:, None] * drift
        if np.linalg.norm(path[:, None] - ends, axis=-1).min() > LEAST_GAP_M:
            return np.array([*eye, rng.uniform(1.8, 3.5)]), np.array([*drift, 0.0])


def _posed(frame, off_m, off_rad):
    turn, rotation = np.empty(4), np.empty((3, 3))
    quat_from_rotation_vector(*off_rad.tolist(), turn)
    matrix_from_quat(turn, rotation)
    return DepthImage(
        depth_m=frame.depth_m,
        fx=frame.fx,
        fy=frame.fy,
        cx=frame.cx,
        cy=frame.cy,
        position_enu_m=tuple((np.array(frame.position_enu_m) + off_m).tolist()),
        rotation_enu_from_optical=rotation @ frame.rotation_enu_from_optical,
    )


def follow(looks, tracker=None):
    """Rows of errors of position and velocity, true and estimated speed; m, m/s.

    One for each image that shows it after it was long enough in view; of NaN where nothing follows.
    """
    tracker, rows, in_view_s = MoverTracker() if tracker is None else tracker, [], 0.0
    for look in looks:
        tracker.update(look.time_s, look.image, lambda points: points[:, 2])
        in_view_s = in_view_s + PERIOD_S if look.is_in_view else 0.0
        if in_view_s <= IN_VIEW_S:
            continue
        moving = tracker.moving(look.time_s)
        speed_mps = float(np.linalg.norm(look.velocity_enu_mps))
        row = [math.nan, math.nan, speed_mps, math.nan]
        gaps = [_gap_m(look, position - look.off_m) for position in moving.position_enu_m]
        if gaps and min(gaps) < NEAR_OUTLINE_M:
            i = int(np.argmin(gaps))
            row[0] = float(
                np.linalg.norm(moving.position_enu_m[i] - look.off_m - look.position_enu_m)
            )
            row[1] = float(np.linalg.norm(moving.velocity_enu_mps[i] - look.velocity_enu_mps))
            row[3] = float(np.linalg.norm(moving.velocity_enu_mps[i]))
        rows.append(row)
    return np.array(rows).reshape(-1, 4)


def _gap_m(look, position):
    c, s = math.cos(look.yaw_rad), math.sin(look.yaw_rad)
    x, y, z = position - look.position_enu_m
    local = np.abs([c * x + s * y, c * y - s * x, z])
    return float(np.linalg.norm(np.maximum(local - look.half_m, 0.0)))
