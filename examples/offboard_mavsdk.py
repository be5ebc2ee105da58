"""Offboard by MAVSDK: up to 10 m, a square at 3 m/s, and down again.

It needs a running testbench and MAVSDK-Python, which is two packages from version 4 on:

    pip install mavsdk mavsdk-grpc
    aeroscene sitl field
    python examples/offboard_mavsdk.py          in another terminal
"""

import asyncio
import sys

from mavsdk_grpc import System
from mavsdk_grpc.offboard import PositionNedYaw, VelocityNedYaw


async def until(stream, is_reached):
    """The first sample of a telemetry stream that is as wanted."""
    async for sample in stream:
        if is_reached(sample):
            return sample
    raise ConnectionError("telemetry ended")


async def main(address: str = "udpin://0.0.0.0:14540", server_port: str = "50051") -> None:
    drone = System(port=int(server_port))
    await drone.connect(system_address=address)
    await until(drone.telemetry.health(), lambda h: h.is_local_position_ok and h.is_armable)

    start = await until(drone.telemetry.position_velocity_ned(), lambda _: True)
    north_m, east_m = start.position.north_m, start.position.east_m
    await drone.offboard.set_position_ned(PositionNedYaw(north_m, east_m, -10.0, 0.0))
    await drone.action.arm()
    await drone.offboard.start()
    await until(drone.telemetry.position(), lambda p: p.relative_altitude_m > 9.5)

    for north_mps, east_mps in ((3.0, 0.0), (0.0, 3.0), (-3.0, 0.0), (0.0, -3.0)):
        await drone.offboard.set_velocity_ned(VelocityNedYaw(north_mps, east_mps, 0.0, 0.0))
        await until(
            drone.telemetry.velocity_ned(),
            lambda v, n=north_mps, e=east_mps: abs(v.north_m_s - n) + abs(v.east_m_s - e) < 0.5,
        )
        print(f"flying {north_mps:.0f} m/s north, {east_mps:.0f} m/s east")

    await drone.offboard.set_position_ned(PositionNedYaw(north_m, east_m, -10.0, 0.0))
    await until(
        drone.telemetry.position_velocity_ned(),
        lambda p: abs(p.position.north_m - north_m) + abs(p.position.east_m - east_m) < 1.0,
    )
    await drone.action.land()
    await until(drone.telemetry.armed(), lambda is_armed: not is_armed)
    print("landed")


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:]))
