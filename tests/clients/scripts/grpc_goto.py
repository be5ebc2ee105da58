"""MAVSDK-Python, gRPC style: take off, go to a place 20 m above home, hold."""

import asyncio
import math
import sys

from mavsdk_grpc import System

NORTH_M = 12.0
DEGREES_PER_METRE = 1.0 / 111_200.0


async def wait_until_ready(drone):
    async for state in drone.core.connection_state():
        if state.is_connected:
            break
    async for health in drone.telemetry.health():
        if health.is_global_position_ok and health.is_home_position_ok:
            break


async def run(address, server_port):
    drone = System(port=server_port)
    await drone.connect(system_address=address)
    await wait_until_ready(drone)
    home = await anext(drone.telemetry.home())
    await drone.action.arm()
    await drone.action.takeoff()
    await asyncio.sleep(0.5)

    latitude_deg = home.latitude_deg + NORTH_M * DEGREES_PER_METRE
    altitude_m = home.absolute_altitude_m + 20.0
    await drone.action.goto_location(latitude_deg, home.longitude_deg, altitude_m, 90.0)
    async for position in drone.telemetry.position():
        north_m = (position.latitude_deg - home.latitude_deg) / DEGREES_PER_METRE
        if abs(position.relative_altitude_m - 20.0) < 1.0 and abs(north_m - NORTH_M) < 1.0:
            break
    async for heading in drone.telemetry.heading():
        if abs(heading.heading_deg - 90.0) < 10.0:
            break
    await drone.action.hold()
    async for mode in drone.telemetry.flight_mode():
        if mode.name == "HOLD":
            break
    async for velocity in drone.telemetry.velocity_ned():
        if math.hypot(velocity.north_m_s, velocity.east_m_s) < 0.5:
            break


asyncio.run(run(sys.argv[1], int(sys.argv[2])))
