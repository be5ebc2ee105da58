"""MAVSDK-Python, gRPC style: wait for a position, arm, take off, land."""

import asyncio
import sys

from mavsdk_grpc import System


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
    version = await drone.info.get_version()
    assert version.flight_sw_major == 1, version

    await drone.action.set_takeoff_altitude(4.0)
    assert await drone.action.get_takeoff_altitude() == 4.0
    await drone.action.arm()
    await drone.action.takeoff()
    async for position in drone.telemetry.position():
        if position.relative_altitude_m > 3.5:
            break
    async for is_in_air in drone.telemetry.in_air():
        assert is_in_air
        break

    await drone.action.land()
    async for is_in_air in drone.telemetry.in_air():
        if not is_in_air:
            break
    async for is_armed in drone.telemetry.armed():
        if not is_armed:
            break
    async for position in drone.telemetry.position():
        assert abs(position.relative_altitude_m) < 1.0, position
        break


asyncio.run(run(sys.argv[1], int(sys.argv[2])))
