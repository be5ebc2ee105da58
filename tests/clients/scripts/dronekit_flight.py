"""DroneKit: arm, simple_takeoff to its height, simple_goto, a mission up, down and flown, RTL."""

import math
import sys
import time

from dronekit import Command, LocationGlobalRelative, VehicleMode, connect
from pymavlink import mavutil

MAV = mavutil.mavlink


def wait(what, is_so, limit_s=90.0):
    deadline = time.monotonic() + limit_s
    while not is_so():
        assert time.monotonic() < deadline, (
            f"{what} not reached: {vehicle.location.global_relative_frame}"
        )
        time.sleep(0.1)


def height_m():
    return vehicle.location.global_relative_frame.alt


def distance_m(place):
    here = vehicle.location.global_relative_frame
    north = (here.lat - place.lat) * 111_319.5
    east = (here.lon - place.lon) * 111_319.5 * math.cos(math.radians(place.lat))
    return math.hypot(north, east)


vehicle = connect(sys.argv[1], wait_ready=True, heartbeat_timeout=60, timeout=60)
wait("armable", lambda: vehicle.is_armable)
vehicle.wait_ready("autopilot_version", timeout=30)
assert str(vehicle.version).startswith("APM:Copter-4."), vehicle.version

vehicle.parameters["RTL_ALT"] = 800
wait("parameter set", lambda: vehicle.parameters["RTL_ALT"] == 800.0)

vehicle.mode = VehicleMode("GUIDED")
wait("guided", lambda: vehicle.mode.name == "GUIDED")
vehicle.armed = True
wait("armed", lambda: vehicle.armed)
vehicle.simple_takeoff(6)
wait("up", lambda: height_m() > 5.7)
time.sleep(1.0)
assert height_m() < 6.4, height_m()

start = vehicle.location.global_relative_frame
place = LocationGlobalRelative(start.lat + 1e-4, start.lon, 8)
vehicle.simple_goto(place)
wait("there", lambda: distance_m(place) < 1.0 and abs(height_m() - 8) < 0.5)
assert vehicle.mode.name == "GUIDED"

frame = MAV.MAV_FRAME_GLOBAL_RELATIVE_ALT
mission = vehicle.commands
mission.download()
mission.wait_ready()
mission.clear()
legs = [(start.lat + 2e-4, start.lon), (start.lat + 2e-4, start.lon + 1e-4)]
for lat, lon in legs:
    mission.add(Command(0, 0, 0, frame, MAV.MAV_CMD_NAV_WAYPOINT, 0, 0, 0, 0, 0, 0, lat, lon, 10))
mission.upload()
mission.download()
mission.wait_ready()
read = [(item.x, item.y) for item in mission]
assert len(read) == len(legs)
for (x, y), (lat, lon) in zip(read, legs, strict=True):
    assert abs(x - lat) < 5e-6, (read, legs)  # float32
    assert abs(y - lon) < 5e-6, (read, legs)
assert abs(vehicle.home_location.lat - start.lat) < 1e-5
vehicle.mode = VehicleMode("AUTO")
wait("auto", lambda: vehicle.mode.name == "AUTO")
last = LocationGlobalRelative(*legs[-1], 10)
wait("mission flown", lambda: distance_m(last) < 2.0)
assert mission.next == 2, mission.next

vehicle.mode = VehicleMode("RTL")
wait("rtl", lambda: vehicle.mode.name == "RTL")
wait("landed", lambda: not vehicle.armed, limit_s=150.0)
assert distance_m(vehicle.home_location) < 1.0
vehicle.close()
