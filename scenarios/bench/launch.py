"""Launch time of a real `aeroscene-sitl`, to its first heartbeat on the network."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
import time

from scenarios.doctor.network import is_free

LOOPBACK = "127.0.0.1"
_TIMEOUT_S = 60.0
_HEARTBEAT_ID = b"\x00\x00\x00"
_GCS_PORT, _SDK_PORT, _TCP_PORT = 14550, 14540, 5760
_VEHICLE_PORTS = (18570, 14580)


class LaunchError(RuntimeError):
    """The launch yielded no heartbeat."""


def seconds_to_first_heartbeat(scene: str, vehicle: str) -> float:
    """Launch the testbench as a user does, and listen as a ground station does.

    Raises:
        LaunchError: If no heartbeat comes, or no instance has free ports.
    """
    instance = _free_instance()
    command = [sys.executable, "-m", "scenarios.cli.sitl", "--scene", scene, "--vehicle", vehicle]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as station:
        station.bind((LOOPBACK, _GCS_PORT + instance))
        station.settimeout(_TIMEOUT_S)
        start_s = time.perf_counter()
        process = subprocess.Popen(  # noqa: S603 - arguments are ours
            [*command, "--instance", str(instance)],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            start_new_session=True,
        )
        try:
            while not _has_heartbeat(station.recv(65536)):
                pass
            return time.perf_counter() - start_s
        except TimeoutError:
            raise LaunchError(f"no heartbeat within {_TIMEOUT_S:.0f} s") from None
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGINT)
            process.communicate()


def _has_heartbeat(datagram: bytes) -> bool:
    """Whether a datagram's first MAVLink 2 frame is a heartbeat."""
    return datagram[:1] == b"\xfd" and datagram[7:10] == _HEARTBEAT_ID


def _free_instance() -> int:
    """An instance with all ports free, far from those that people use."""
    for instance in range(99, 9, -1):
        udp = [port + instance for port in (_GCS_PORT, _SDK_PORT, *_VEHICLE_PORTS)]
        tcp = _TCP_PORT + 10 * instance
        if all(is_free(socket.SOCK_DGRAM, p) for p in udp) and is_free(socket.SOCK_STREAM, tcp):
            return instance
    raise LaunchError("no instance from 10 to 99 has all its ports free")
