"""Crossing traffic: a mover that meets the vehicle on its plan."""

import math

import numpy as np

from flightsim.environment.motion import new_movers, place_mover
from flightsim.environment.movers import MOVER_KINDS, MovingObstacle

REACH_M = 9.0


def crosser(plan, begun_s, share, speed_mps, *, kind="drone", angle_deg=90.0):
    """Mover that is at the vehicle's place at a share of its plan's duration.

    Args:
        plan: Trajectory to be flown.
        begun_s: Start time of the plan.
        share: Share of its duration at which they meet.
        speed_mps: Speed of the mover.
        kind: Kind of the mover.
        angle_deg: Angle between both motions; 180 is head on.
    """
    meet_s = share * plan.duration_s
    at = plan.positions(np.array([meet_s]))[0]
    vx, vy, _ = plan.derivatives(np.array([meet_s]), 1)[0]
    heading = math.atan2(vy, vx) + math.radians(angle_deg)
    way = np.array([math.cos(heading), math.sin(heading), 0.0])
    at = at - [0.0, 0.0, MOVER_KINDS[kind].size_m[2] / 2]
    path = tuple(tuple((at + d * way).tolist()) for d in (-REACH_M, REACH_M))
    phases = np.linspace(0.0, 1.0, 2001)[:-1]
    movers, points = new_movers(
        [MovingObstacle(kind=kind, path_enu_m=path, speed_mps=speed_mps, phase=p) for p in phases]
    )
    for mover in movers:
        place_mover(mover, points, begun_s + meet_s, 1.0)
    # It is there twice per round: use the time on the way out.
    off = np.linalg.norm(movers["position_enu_m"] - at, axis=1)
    is_outward = movers["velocity_enu_mps"] @ way > 0
    best = int(np.argmin(np.where(is_outward, off, np.inf)))
    return MovingObstacle(
        kind=kind, path_enu_m=path, speed_mps=speed_mps, phase=float(phases[best])
    )
