"""MAVSDK-Python, gRPC style: offboard positions in the local frame, right after arming."""

import asyncio
import sys

from mavsdk_grpc import System
from mavsdk_grpc.offboard import OffboardError, PositionNedYaw


async def reach(drone, north_m, east_m, down_m):
    async for sample in drone.telemetry.position_velocity_ned():
        at = sample.position
        errors = (at.north_m - north_m, at.east_m - east_m, at.down_m - down_m)
        if max(map(abs, errors)) < 0.5:
            return


async def wait_until_ready(drone):
    async for state in drone.core.connection_state():
        if state.is_connected:
            break
    async for health in drone.telemetry.health():
        if health.is_global_position_ok and health.is_home_position_ok:
            break


async def starting_offboard_fails_with(drone):
    try:
        await drone.offboard.start()
    except OffboardError as error:
        return error._result.result.name
    return None


async def run(address, server_port):
    drone = System(port=server_port)
    await drone.connect(system_address=address)
    await wait_until_ready(drone)

    assert await starting_offboard_fails_with(drone) == "NO_SETPOINT_SET"

    await drone.action.arm()
    await drone.offboard.set_position_ned(PositionNedYaw(0.0, 0.0, 0.0, 0.0))
    await drone.offboard.start()
    for north_m, east_m, down_m, yaw_deg in ((0, 0, -5, 0), (5, 0, -8, 90), (5, 6, -8, 90)):
        await drone.offboard.set_position_ned(PositionNedYaw(north_m, east_m, down_m, yaw_deg))
        await reach(drone, north_m, east_m, down_m)
    async for attitude in drone.telemetry.attitude_euler():
        if abs(attitude.yaw_deg - 90.0) < 10.0:
            break
    await drone.offboard.stop()
    async for mode in drone.telemetry.flight_mode():
        if mode.name == "HOLD":
            break


asyncio.run(run(sys.argv[1], int(sys.argv[2])))
