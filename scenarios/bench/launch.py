"""Cost of launching a real `aeroscene sitl`, up to its first heartbeat on the network.

A real process on real ports is measured, in CPU time, so that imports and the building of the world
are included and the figure holds on a busy machine too.
"""

from __future__ import annotations

import contextlib
import os
import resource
import signal
import socket
import subprocess
import sys
from collections.abc import Mapping

from scenarios.doctor.network import is_free

LOOPBACK = "127.0.0.1"
_COMMAND = "import sys; from scenarios.cli.entry import aeroscene_sitl; sys.exit(aeroscene_sitl())"
"""Body of the console script, which needs no installed script to be found."""
_TIMEOUT_S = 60.0
_HEARTBEAT_ID = b"\x00\x00\x00"
_GCS_PORT, _SDK_PORT, _TCP_PORT = 14550, 14540, 5760
_VEHICLE_PORTS = (18570, 14580)


class LaunchError(RuntimeError):
    """The launch brought no heartbeat, or no instance has free ports."""


def cpu_seconds_to_first_heartbeat(scene: str, vehicle: str) -> float:
    """Return the CPU time of a launch as a user sees it from the second time on.

    The first of two launches writes Python's bytecode into a folder of its own. Only the second one
    is measured.

    Args:
        scene: Scene as `aeroscene sitl` takes it.
        vehicle: Airframe by its name.

    Raises:
        LaunchError: If no heartbeat comes, or no instance has free ports.
    """
    environment = dict(os.environ)
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    _launch(scene, vehicle, environment)
    before_s = _cpu_seconds_of_children()
    _launch(scene, vehicle, environment)
    return _cpu_seconds_of_children() - before_s


def _cpu_seconds_of_children() -> float:
    """Return the CPU seconds of all child processes that have ended and been waited for."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def _launch(scene: str, vehicle: str, environment: Mapping[str, str]) -> None:
    """Launch the testbench, listen as a ground station does, and end it at the first heartbeat."""
    instance = _free_instance()
    command = [sys.executable, "-c", _COMMAND, "--scene", scene, "--vehicle", vehicle]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as station:
        station.bind((LOOPBACK, _GCS_PORT + instance))
        station.settimeout(_TIMEOUT_S)
        process = subprocess.Popen(  # noqa: S603 - arguments are ours
            [*command, "--instance", str(instance)],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            env=dict(environment),
            start_new_session=True,
        )
        try:
            while not _has_heartbeat(station.recv(65536)):
                pass
        except TimeoutError:
            raise LaunchError(f"no heartbeat within {_TIMEOUT_S:.0f} s") from None
        finally:
            with contextlib.suppress(ProcessLookupError):
                # Killed, because an orderly end would count too.
                os.killpg(process.pid, signal.SIGKILL)
            process.communicate()


def _has_heartbeat(datagram: bytes) -> bool:
    """Return true if a datagram's first MAVLink 2 frame is a heartbeat, whose message id is 0."""
    return datagram[:1] == b"\xfd" and datagram[7:10] == _HEARTBEAT_ID


def _free_instance() -> int:
    """Return an instance with all ports free, far from those that people use."""
    for instance in range(99, 9, -1):
        udp = [port + instance for port in (_GCS_PORT, _SDK_PORT, *_VEHICLE_PORTS)]
        tcp = _TCP_PORT + 10 * instance
        if all(is_free(socket.SOCK_DGRAM, p) for p in udp) and is_free(socket.SOCK_STREAM, tcp):
            return instance
    raise LaunchError("no instance from 10 to 99 has all its ports free")
