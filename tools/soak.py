"""A day of flights of one vehicle, which shows if memory stays flat.

    python tools/soak.py --hours 24                    # about 15 minutes of a core

A companion in the process commands it over MAVLink: arm, take off, fly a mission of four waypoints
that ends in a landing, again and again, with a full battery for each flight. Prints a JSON row for
each simulated hour; the exit status is 1 where memory grows beyond the limit after the first hour,
or where a flight does not end on the ground.
"""

from __future__ import annotations

import argparse
import gc
import json
import sys
import time

import psutil
from pymavlink.dialects.v20 import common as mavlink

from aeroscene.sources import load_scene
from flightsim.autopilot.mission_item import MissionItem
from flightsim.mavlink.client import MavlinkClient
from flightsim.testbench import Testbench, TestbenchCfg
from flightsim.vehicles.battery import Battery

MOST_GROWTH_MB = 20.0
_HEIGHT_M = 8.0
_CORNERS_M = ((30.0, 0.0), (30.0, 25.0), (0.0, 25.0), (0.0, 0.0))
_LONGEST_FLIGHT_S = 600.0
_RELATIVE_FRAME = 6  # MAV_FRAME_GLOBAL_RELATIVE_ALT_INT
_HOUR_S = 3600.0


class FlightError(RuntimeError):
    """A command was refused, or a flight did not end on the ground."""


class Vehicle:
    """A vehicle on the field, and the companion that commands it."""

    def __init__(self, seed: int) -> None:
        self.bench = Testbench(
            load_scene("field"), TestbenchCfg(speed="max", seed=seed), has_network=False
        )
        self._client: MavlinkClient = self.bench.connect()
        self.bench.observers.append(lambda: self._client.update(self.bench.plant.time_us))
        # The estimator settles before the vehicle lets itself be armed.
        self.bench.run(5.0)

    @property
    def time_s(self) -> float:
        """Simulated time since the start, s."""
        return 1e-6 * self.bench.plant.time_us

    def fly(self) -> None:
        """Fly one mission from the ground to the ground, with a full battery.

        Raises:
            FlightError: If a command is refused or the flight does not end.
        """
        self.bench.plant.battery = Battery(self.bench.airframe.battery)
        self.bench.run(2.0)  # The battery is looked at twice a second.
        self._command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1)
        self._command(mavlink.MAV_CMD_MISSION_START, 0, 0)
        autopilot = self.bench.autopilot
        self.bench.run(_LONGEST_FLIGHT_S, until=lambda: not autopilot.is_armed)
        if autopilot.is_armed:
            raise FlightError(f"still armed {_LONGEST_FLIGHT_S:g} s after the start")

    def upload(self) -> None:
        """Give the vehicle the mission: take off, the corners of a rectangle, land."""
        x, y, _ = self.bench.plant.truth.position_enu_m
        items = [self._item(mavlink.MAV_CMD_NAV_TAKEOFF, x, y, _HEIGHT_M)]
        for east_m, north_m in _CORNERS_M:
            items.append(
                self._item(mavlink.MAV_CMD_NAV_WAYPOINT, x + east_m, y + north_m, _HEIGHT_M)
            )
        items.append(self._item(mavlink.MAV_CMD_NAV_LAND, x, y, 0.0))
        self.bench.autopilot.mission.replace(items)

    def _item(self, command: int, east_m: float, north_m: float, up_m: float) -> MissionItem:
        place = self.bench.frame.geodetic_from_enu((east_m, north_m, 0.0))
        return MissionItem(
            command=command,
            frame=_RELATIVE_FRAME,
            x=place.latitude_deg,
            y=place.longitude_deg,
            z=up_m,
        )

    def _command(self, number: int, *parameters: float) -> None:
        command = self._client.command(number, *parameters)
        self.bench.run(10.0, until=lambda: command.is_done)
        if not command.is_accepted:
            raise FlightError(f"command {number}: {command.outcome()}")


def soak(hours: float, seed: int) -> bool:
    """Fly for simulated hours, and print a row for each.

    Args:
        hours: Simulated hours.
        seed: Seed of sensors and wind.

    Returns:
        True if memory stayed flat after the first hour.

    Raises:
        FlightError: If a flight does not end as it should.
    """
    process, cpu_s = psutil.Process(), time.process_time()
    vehicle = Vehicle(seed)
    vehicle.upload()
    n_flights, n_hours, first_bytes = 0, 0, 0
    growth_mb = 0.0
    while vehicle.time_s < hours * _HOUR_S:
        vehicle.fly()
        n_flights += 1
        if vehicle.time_s < (n_hours + 1) * _HOUR_S:
            continue
        n_hours = int(vehicle.time_s / _HOUR_S)
        # What only awaits collection is no leak.
        gc.collect()
        now_bytes = process.memory_info().rss
        # The first hour fills caches and logs of a fixed size.
        first_bytes = first_bytes or now_bytes
        growth_mb = max(growth_mb, 1e-6 * (now_bytes - first_bytes))
        row = {
            "hours": round(vehicle.time_s / _HOUR_S, 2),
            "flights": n_flights,
            "memory_mb": round(1e-6 * now_bytes, 1),
            "growth_mb": round(growth_mb, 1),
            "cpu_s": round(time.process_time() - cpu_s, 1),
        }
        print(json.dumps(row), flush=True)
    vehicle.bench.close()
    return growth_mb <= MOST_GROWTH_MB


def main() -> int:
    """Soak for the hours of the command line.

    Returns:
        Exit status: 1 if memory grows beyond the limit.
    """
    parser = argparse.ArgumentParser(description="Memory of a vehicle that flies for long")
    parser.add_argument("--hours", type=float, default=24.0, help="simulated hours")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    return 0 if soak(options.hours, options.seed) else 1


if __name__ == "__main__":
    sys.exit(main())
