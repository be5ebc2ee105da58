"""Offboard by pymavlink: up to 8 m, 6 m to the north, and down again.

It needs a running testbench:

    aeroscene sitl field
    python examples/offboard_pymavlink.py       in another terminal
"""

import sys
import time

from pymavlink import mavutil
from pymavlink.dialects.v20 import common as mavlink

POSITION_ONLY = 0b1101_1111_1000  # ignore velocity, acceleration, yaw and yaw rate


def position(drone):
    """Present position in the local frame: north, east, down."""
    at = drone.recv_match(type="LOCAL_POSITION_NED", blocking=True, timeout=5)
    return at.x, at.y, at.z


def send_setpoint(drone, goal_ned_m) -> None:
    address = (0, drone.target_system, drone.target_component)
    how = (mavlink.MAV_FRAME_LOCAL_NED, POSITION_ONLY)
    drone.mav.set_position_target_local_ned_send(*address, *how, *goal_ned_m, *(0.0,) * 8)


def fly_to(drone, goal_ned_m) -> None:
    """Send the goal again and again, as offboard mode asks, until it is reached."""
    while max(abs(a - b) for a, b in zip(position(drone), goal_ned_m, strict=True)) > 0.5:
        send_setpoint(drone, goal_ned_m)
    print("reached", goal_ned_m)


def main(address: str = "tcp:127.0.0.1:5760") -> None:
    drone = mavutil.mavlink_connection(address, source_system=255)
    drone.wait_heartbeat()
    prearm_check = mavlink.MAV_SYS_STATUS_PREARM_CHECK
    while True:  # healthy first: right after the start the estimator is not aligned
        status = drone.recv_match(type="SYS_STATUS", blocking=True, timeout=5)
        if status.onboard_control_sensors_health & prearm_check:
            break
    x, y, z = position(drone)
    for _ in range(20):
        send_setpoint(drone, (x, y, z))
        time.sleep(0.05)
    drone.set_mode("OFFBOARD")
    drone.arducopter_arm()
    drone.motors_armed_wait()
    fly_to(drone, (x, y, z - 8.0))
    fly_to(drone, (x + 6.0, y, z - 8.0))
    drone.set_mode("LAND")
    drone.motors_disarmed_wait()
    print("landed")


if __name__ == "__main__":
    main(*sys.argv[1:])
