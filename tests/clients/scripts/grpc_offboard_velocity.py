"""MAVSDK-Python, gRPC style: offboard velocities in the local and in the body frame."""

import asyncio
import sys

from mavsdk_grpc import System
from mavsdk_grpc.offboard import VelocityBodyYawspeed, VelocityNedYaw


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

    await drone.action.arm()
    await drone.offboard.set_velocity_ned(VelocityNedYaw(0.0, 0.0, 0.0, 0.0))
    await drone.offboard.start()
    await drone.offboard.set_velocity_ned(VelocityNedYaw(0.0, 0.0, -2.0, 0.0))
    async for position in drone.telemetry.position():
        if position.relative_altitude_m > 15.0:
            break
    await drone.offboard.set_velocity_ned(VelocityNedYaw(2.0, 0.0, 0.0, 90.0))
    async for velocity in drone.telemetry.velocity_ned():
        if velocity.north_m_s > 1.7 and abs(velocity.east_m_s) < 0.4:
            break
    async for attitude in drone.telemetry.attitude_euler():
        if abs(attitude.yaw_deg - 90.0) < 10.0:
            break

    # The nose points east now: forward is east.
    await drone.offboard.set_velocity_body(VelocityBodyYawspeed(2.0, 0.0, 0.0, 0.0))
    async for velocity in drone.telemetry.velocity_ned():
        if velocity.east_m_s > 1.7 and abs(velocity.north_m_s) < 0.4:
            break
    await drone.offboard.set_velocity_body(VelocityBodyYawspeed(0.0, 0.0, 0.0, 60.0))
    async for rates in drone.telemetry.attitude_angular_velocity_body():
        if rates.yaw_rad_s > 0.8:
            break
    await drone.offboard.stop()


asyncio.run(run(sys.argv[1], int(sys.argv[2])))
