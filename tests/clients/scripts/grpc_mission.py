"""MAVSDK-Python, gRPC style: upload a mission, fly it, follow its progress, download it."""

import asyncio
import sys

from mavsdk_grpc import System
from mavsdk_grpc.mission import MissionItem, MissionPlan

DEGREES_PER_METRE = 1.0 / 111_200.0
NAN = float("nan")


def item(latitude_deg, longitude_deg):
    return MissionItem(
        latitude_deg,
        longitude_deg,
        20.0,  # relative altitude, m
        10.0,  # speed, m/s
        True,  # fly through
        NAN,
        NAN,
        MissionItem.CameraAction.NONE,
        NAN,
        NAN,
        NAN,
        NAN,
        NAN,
        MissionItem.VehicleAction.NONE,
    )


async def follow_progress(drone, seen):
    async for progress in drone.mission.mission_progress():
        seen.append((progress.current, progress.total))
        if progress.total and progress.current == progress.total:
            return


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

    offsets = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0)]
    plan = MissionPlan(
        [
            item(
                home.latitude_deg + north_m * DEGREES_PER_METRE,
                home.longitude_deg + east_m * DEGREES_PER_METRE,
            )
            for north_m, east_m in offsets
        ]
    )
    await drone.mission.set_return_to_launch_after_mission(True)
    await drone.mission.upload_mission(plan)
    downloaded = await drone.mission.download_mission()
    pairs = zip(downloaded.mission_items, plan.mission_items, strict=True)
    assert all(abs(found.latitude_deg - sent.latitude_deg) < 1e-6 for found, sent in pairs)

    await drone.action.arm()
    seen = []
    progress = asyncio.create_task(follow_progress(drone, seen))
    await drone.mission.start_mission()
    await progress
    assert {total for _, total in seen} == {3}, seen
    assert [current for current, _ in seen] == sorted(current for current, _ in seen), seen
    assert await drone.mission.is_mission_finished()
    async for mode in drone.telemetry.flight_mode():
        if mode.name == "RETURN_TO_LAUNCH":
            break
    await drone.mission.clear_mission()


asyncio.run(run(sys.argv[1], int(sys.argv[2])))
