"""A program that a campaign starts for each trial: it flies over MAVLink, and keeps the time.

    aeroscene campaign --scenes 0:4 --trials 5 --pilot mavlink --out runs/mine \
        --program "python examples/scored_mavlink.py"

The task is a line of JSON on standard input; the local frame has its origin where the vehicle
stands at first. This program flies straight up, across and down.
"""

import json
import math
import sys

from pymavlink import mavutil
from pymavlink.dialects.v20 import common as mav

POSITION_ONLY = 0b1101_1111_1000  # ignore velocity, acceleration, yaw and yaw rate
TICKS, SPEED_MPS, HOVER_M = 5, 2.5, 3.0


def command(drone, number, *parameters) -> None:
    filled = [*parameters, *[math.nan] * (7 - len(parameters))]
    drone.mav.command_long_send(0, 0, number, 0, *filled)  # to whoever is there
    assert drone.recv_match(type="COMMAND_ACK", blocking=True).result == 0, number


def step(drone, ticks=TICKS) -> None:
    command(drone, mav.MAV_CMD_USER_1, ticks)  # 20 ms each


def fly_line(drone, start_enu_m, end_enu_m) -> None:
    steps = math.ceil(1.5 * math.dist(start_enu_m, end_enu_m) / SPEED_MPS / (0.02 * TICKS))
    for share in [*((n + 1) / steps for n in range(steps)), *[1.0] * 10]:
        way = zip(start_enu_m, end_enu_m, strict=True)
        east, north, up = (a + share * share * (3 - 2 * share) * (b - a) for a, b in way)
        goal_ned_m = (mav.MAV_FRAME_LOCAL_NED, POSITION_ONLY, north, east, -up)
        drone.mav.set_position_target_local_ned_send(0, 0, 0, *goal_ned_m, *[0.0] * 8)
        step(drone)


def main() -> None:
    task = json.loads(sys.stdin.readline())
    ends = zip(task["area"]["centroid"], task["local_origin_enu_m"], strict=True)
    east, north, up = (goal - origin for goal, origin in ends)
    drone, top = mavutil.mavlink_connection(task["url"]), max(up, 0.0) + HOVER_M
    step(drone, 150)  # the estimator aligns
    fly_line(drone, [0, 0, 0], [0, 0, 0.01])  # offboard mode wants a stream of setpoints first
    command(drone, mav.MAV_CMD_DO_SET_MODE, 1 + 128, 6)  # PX4's offboard mode
    command(drone, mav.MAV_CMD_COMPONENT_ARM_DISARM, 1, 0)
    fly_line(drone, [0, 0, 0], [0, 0, top])
    fly_line(drone, [0, 0, top], [east, north, up + HOVER_M])
    command(drone, mav.MAV_CMD_NAV_LAND)
    while drone.messages["HEARTBEAT"].base_mode & mav.MAV_MODE_FLAG_SAFETY_ARMED:
        step(drone, 50)


if __name__ == "__main__":
    main()
