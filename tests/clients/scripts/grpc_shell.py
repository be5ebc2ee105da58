"""MAVSDK-Python, gRPC style: the shell and, after a flight, its log, whole and in order."""

import asyncio
import struct
import sys
import tempfile
from pathlib import Path

from mavsdk_grpc import System
from mavsdk_grpc.shell import Device


async def ask(drone, line):
    """Type a line, and read until the next prompt."""

    async def listen():
        text = ""
        async for piece in drone.shell.receive():
            text += piece.data
            if text.endswith("nsh> "):
                return text
        raise AssertionError(text)

    task = asyncio.create_task(listen())
    await asyncio.sleep(0.5)
    await drone.shell.send(line, Device.SHELL)
    return await asyncio.wait_for(task, 30.0)


async def run(address, server_port):
    drone = System(port=server_port)
    await drone.connect(system_address=address)
    async for health in drone.telemetry.health():
        if health.is_global_position_ok and health.is_armable:
            break
    assert "listener TOPIC" in await ask(drone, "help")
    assert "MIS_TAKEOFF_ALT: 2.5" in await ask(drone, "param show MIS_TAKEOFF_ALT")

    assert "accepted" in await ask(drone, "commander takeoff")
    await asyncio.sleep(3.0)
    assert "accepted" in await ask(drone, "commander land")
    async for is_armed in drone.telemetry.armed():
        if not is_armed:
            break
    (entry,) = await drone.log_files.get_entries()
    path = Path(tempfile.mkdtemp()) / "flight.ulg"
    async for _ in drone.log_files.download_log_file(entry, str(path)):
        pass
    data = path.read_bytes()
    assert len(data) == entry.size_bytes
    at = 16
    while at < len(data):
        at += 3 + struct.unpack_from("<H", data, at)[0]
    assert at == len(data)
    listing = await drone.ftp.list_directory("/log")
    assert [entry.name for entry in listing.entries] == ["0.ulg"]


asyncio.run(run(sys.argv[1], int(sys.argv[2])))
