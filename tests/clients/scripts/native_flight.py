"""MAVSDK 4's native asyncio API: parameters, takeoff, offboard, return."""

import asyncio
import sys

from mavsdk.asyncio import ComponentType, Configuration, Mavsdk
from mavsdk.asyncio.plugins.action import ActionAsync
from mavsdk.asyncio.plugins.offboard import OffboardAsync, PositionNedYaw
from mavsdk.asyncio.plugins.param import ParamAsync
from mavsdk.asyncio.plugins.telemetry import TelemetryAsync


async def run(address):
    configuration = Configuration.create_with_component_type(ComponentType.GROUND_STATION)
    async with Mavsdk(configuration) as mavsdk:
        await mavsdk.add_any_connection(address)
        system = await mavsdk.first_autopilot(timeout_s=20.0)
        assert system is not None
        await fly(
            TelemetryAsync(system), ActionAsync(system), OffboardAsync(system), ParamAsync(system)
        )


async def fly(telemetry, action, offboard, param):
    async for health in telemetry.subscribe_health():
        if health.is_global_position_ok and health.is_home_position_ok and health.is_armable:
            break
    await param.set_param_int("COM_TAKEOFF_ACT", 1)
    assert await param.get_param_int("COM_TAKEOFF_ACT") == 1
    await param.set_param_float("MIS_TAKEOFF_ALT", 6.0)
    assert await param.get_param_float("MIS_TAKEOFF_ALT") == 6.0
    parameters = await param.get_all_params()
    assert len(parameters.int_params) > 10
    assert len(parameters.float_params) > 10

    await action.arm()
    await action.takeoff()
    async for position in telemetry.subscribe_position():
        if position.relative_altitude_m > 5.5:
            break
    await offboard.set_position_ned(PositionNedYaw(0.0, 6.0, -8.0, 0.0))
    await offboard.start()
    async for sample in telemetry.subscribe_position_velocity_ned():
        if abs(sample.position.east_m - 6.0) < 0.5 and abs(sample.position.down_m + 8.0) < 0.5:
            break
    await offboard.stop()
    await action.set_return_to_launch_altitude(10.0)
    await action.return_to_launch()
    async for is_armed in telemetry.subscribe_armed():
        if not is_armed:
            break


asyncio.run(run(sys.argv[1]))
