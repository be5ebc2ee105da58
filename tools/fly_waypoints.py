"""Fly a mission with a real flight stack by a client outside, and measure what it does here.

    python tools/fly_waypoints.py px4 ~/PX4-Autopilot/build/px4_sitl_default/bin/px4
    python tools/fly_waypoints.py ardupilot arducopter --vehicle hummingbird
    python tools/fly_waypoints.py px4 px4 --laps 17         # ten simulated minutes of lockstep

The client (`waypoints/client.py`, pymavlink) has it arm, take off, fly ten waypoints on a circle
above all that stands in the scene, hover, return and land. Prints a JSON object: the errors of the
stack's estimate against the truth while armed, its throttle in hover against the one of the
airframe's mass and rotors, what passed in lockstep, and where the time went. The exit status is 1
where one of them misses its limit.
"""

from __future__ import annotations

import argparse
import json
import math
import resource
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from aeroscene.scene.box import rotation_matrix
from aeroscene.sources import load_scene
from autonomy.types import Vector3
from flightsim.bridges.launch import ardupilot, px4
from flightsim.bridges.physics.bridge import Exchanges
from flightsim.testbench import Testbench, TestbenchCfg
from flightsim.vehicles import Airframe
from scenarios.trials.measures.estimation import EstimationErrors

N_WAYPOINTS = 10
# Above all that stands in the scene the circle is free, so that the stack alone is measured.
_RADIUS_M, _CLEARANCE_M = 15.0, 3.0
_HOVER_S = 20.0
# Limits of the errors of a stack's own estimate.
_MOST_POSITION_RMSE_M, _MOST_ATTITUDE_RMSE_DEG = 1.0, 2.0
_MOST_THROTTLE_ERROR_PERCENT = 3.0
_MOST_MISS_M = 2.5
"""Both stacks take a waypoint for reached within 2 m by their estimate."""
_LONGEST_LAP_S = 300.0
_PROGRAM = Path(__file__).parent / "waypoints" / "client.py"


class Watch:
    """Measurements in the process that holds the truth; an observer of the run.

    The client cannot make them: it sees the stack's estimate only.
    """

    def __init__(self, bench: Testbench, places_enu_m: Sequence[Vector3]) -> None:
        self._bench = bench
        self._places_enu_m = np.array(places_enu_m)
        self._miss_m = np.full(len(self._places_enu_m), np.inf)
        self.errors = EstimationErrors()
        self._begun: tuple[float, float] | None = None

    def __call__(self) -> None:
        """Take in the 20 ms that have passed since the last call."""
        bench = self._bench
        # Before its first answer the stack starts up, which is not the speed of lockstep.
        if self._begun is None and bench.external and bench.external.exchanges.answered:
            self._begun = (time.perf_counter(), bench.plant.time_us)
        self.errors.add(bench.plant.history)
        away_m = np.linalg.norm(self._places_enu_m - bench.plant.truth.position_enu_m, axis=1)
        np.minimum(self._miss_m, away_m, out=self._miss_m)

    @property
    def farthest_miss_m(self) -> float:
        """Distance from the waypoint that was passed the farthest, by the truth, m."""
        return float(self._miss_m.max())

    def real_time_factor(self) -> float:
        """Simulated over wall time since the stack's first answer; nan before it."""
        if self._begun is None:
            return math.nan
        began_s, began_us = self._begun
        return 1e-6 * (self._bench.plant.time_us - began_us) / (time.perf_counter() - began_s)


def places(bench: Testbench) -> list[Vector3]:
    """Ten places on a circle about the vehicle, above all that stands in the scene; ENU, m."""
    x, y, z = bench.plant.truth.position_enu_m
    tops_m = [
        # Half the height of a turned box: its sides' shares of the vertical.
        box.p[2] + 0.5 * float(np.abs(rotation_matrix(box.q)[2]) @ np.asarray(box.s))
        for box in (thing.bbox for thing in bench.scene.objects)
    ]
    height_m = max([*tops_m, z + _CLEARANCE_M]) + _CLEARANCE_M
    turns = 2.0 * np.pi * np.arange(N_WAYPOINTS) / N_WAYPOINTS
    return [(x + _RADIUS_M * math.cos(a), y + _RADIUS_M * math.sin(a), height_m) for a in turns]


def mission(bench: Testbench, places_enu_m: Sequence[Vector3]) -> list[tuple[float, float, float]]:
    """Waypoints as MAVLink has them: degrees, and metres above where the vehicle stands.

    Args:
        bench: Testbench, whose vehicle stands at its start.
        places_enu_m: Places to fly to.
    """
    z0 = bench.plant.truth.position_enu_m[2]
    on_earth = [(bench.frame.geodetic_from_enu(place), place[2] - z0) for place in places_enu_m]
    return [(place.latitude_deg, place.longitude_deg, up_m) for place, up_m in on_earth]


def hover_throttle(name: str, airframe: Airframe, altitude_m: float) -> float:
    """Throttle at which a stack hovers, by the mass and the rotors of an airframe.

    ArduPilot commands more in thinner air, so that it needs less throttle where the rotors, as
    ours, lose nothing there.

    Args:
        name: "px4" or "ardupilot".
        airframe: Airframe.
        altitude_m: Height above sea level.
    """
    if name == "px4":
        return px4.parameters(airframe)["MPC_THR_HOVER"]
    return ardupilot.parameters(airframe)["MOT_THST_HOVER"] * _density_ratio(altitude_m)


def _density_ratio(altitude_m: float) -> float:
    """Density of the standard atmosphere over the one at sea level.

    Source: ISO 2533, troposphere: 288.15 K at sea level, 6.5 K less per km.
    """
    return (1.0 - 0.0065 * altitude_m / 288.15) ** 4.2559


def address(name: str, instance: int) -> str:
    """Address at which the stack serves clients, in the words of pymavlink.

    Args:
        name: "px4" or "ardupilot".
        instance: Number of the stack's process; it shifts all ports.
    """
    # PX4 sends to 14540 and up, and all instances from 9 on share the last port.
    if name == "px4":
        return f"udpin:127.0.0.1:{min(14540 + instance, 14549)}"
    return f"tcp:127.0.0.1:{5760 + 10 * instance}"


def fly(options: argparse.Namespace) -> dict[str, Any]:
    """Fly the mission of the command line.

    Returns:
        Row of measurements. Its `fault` is empty if client and stack got to the end.
    """
    cfg = TestbenchCfg(
        autopilot=options.autopilot,
        autopilot_binary=options.binary,
        vehicle=options.vehicle,
        aiding=options.aiding,
        seed=options.seed,
        instance=options.instance,
        speed="max",
    )
    began_s, cpu_s = time.perf_counter(), time.process_time()
    with Testbench(load_scene(options.scene), cfg) as bench:
        places_enu_m = places(bench)
        watch = Watch(bench, places_enu_m)
        bench.observers.append(watch)
        task = {
            "waypoints": mission(bench, places_enu_m),
            "laps": options.laps,
            "hover_s": _HOVER_S,
        }
        told = _with_client(bench, options, task)
        start, end = bench.scene.start_position_enu_m, bench.plant.truth.position_enu_m
        factor = watch.real_time_factor()
        external, sim_s = bench.external, bench.plant.time_us * 1e-6
        assert external is not None
        altitude_m = bench.frame.geodetic_from_enu(places_enu_m[-1]).altitude_m
        expected = hover_throttle(options.autopilot, bench.airframe, altitude_m)
    wall_s, cpu_s = time.perf_counter() - began_s, time.process_time() - cpu_s
    # Only now: children count once they have ended, and the stack ends with the testbench.
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    throttle, client_cpu_s = told.get("hover_throttle", math.nan), told.get("cpu_s", 0.0)
    return {
        "autopilot": options.autopilot,
        "vehicle": options.vehicle,
        "scene": options.scene,
        "fault": external.fault or told.get("fault", ""),
        "waypoints_reported": told.get("waypoints_reported", 0),
        "farthest_miss_m": round(watch.farthest_miss_m, 2),
        "landed_off_m": round(math.dist(start[:2], end[:2]), 2),
        "position_rmse_m": round(watch.errors.position_rmse_m, 3),
        "attitude_rmse_deg": round(watch.errors.attitude_rmse_deg, 2),
        "hover_throttle": round(throttle, 4),
        "hover_throttle_expected": round(expected, 4),
        "hover_throttle_error_percent": round(100.0 * (throttle / expected - 1.0), 2),
        "lockstep": asdict(external.exchanges),
        "sim_s": round(sim_s, 2),
        "wall_s": round(wall_s, 1),
        "real_time_factor": round(factor, 1),
        "real_time_factor_with_start": round(sim_s / wall_s, 1),
        "cpu_s": round(cpu_s, 1),
        "stack_cpu_s": round(children.ru_utime + children.ru_stime - client_cpu_s, 1),
        # The stack's time is what all children took, less the client's.
        "client_cpu_s": round(client_cpu_s, 1),
        "waiting_s": round(wall_s - cpu_s, 1),
    }


def _with_client(
    bench: Testbench, options: argparse.Namespace, task: dict[str, Any]
) -> dict[str, Any]:
    """Run the simulation until the client ends.

    Returns:
        The client's report; only a `fault` if it failed or was not done in time.
    """
    command = [sys.executable, str(_PROGRAM), options.autopilot]
    with subprocess.Popen(  # noqa: S603 - our own program
        [*command, address(options.autopilot, options.instance)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as client:
        assert client.stdin is not None
        client.stdin.write(json.dumps(task))
        client.stdin.close()
        # `communicate` would flush the closed pipe, and raise.
        client.stdin = None
        try:
            bench.run(
                _LONGEST_LAP_S * options.laps,
                until=lambda: client.poll() is not None or bool(bench.fault),
            )
            # Asked before the client is ended, which is harmless if it has ended by itself.
            is_late = client.poll() is None
        finally:
            client.kill()
        out, _ = client.communicate()
    if is_late:
        return {"fault": "the client has not come to an end"}
    return json.loads(out or '{"fault": "the client has failed"}')


def misses(row: dict[str, Any]) -> list[str]:
    """Names of the figures that miss their limits.

    Args:
        row: Row of `fly`.
    """
    limits = {
        "fault": not row["fault"],
        "farthest_miss_m": row["farthest_miss_m"] <= _MOST_MISS_M,
        "position_rmse_m": row["position_rmse_m"] < _MOST_POSITION_RMSE_M,
        "attitude_rmse_deg": row["attitude_rmse_deg"] < _MOST_ATTITUDE_RMSE_DEG,
        "hover_throttle": abs(row["hover_throttle_error_percent"]) <= _MOST_THROTTLE_ERROR_PERCENT,
        "lockstep": Exchanges(**row["lockstep"]).is_whole,
    }
    return [name for name, is_kept in limits.items() if not is_kept]


def main() -> int:
    """Fly what the command line asks for, and print the row.

    Returns:
        Exit status: 1 if a figure misses its limit.
    """
    parser = argparse.ArgumentParser(
        description="A mission with a real flight stack",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    parser.add_argument("autopilot", choices=("px4", "ardupilot"))
    parser.add_argument("binary", help="the stack's program, built for simulation")
    parser.add_argument("--scene", default="42", help="number or file of the scene")
    parser.add_argument("--vehicle", default="iris", help="airframe with four rotors")
    parser.add_argument(
        "--aiding", choices=("gnss", "auto"), default="auto", help="auto: odometry too"
    )
    parser.add_argument("--laps", type=int, default=1, help="times that the circle is flown")
    parser.add_argument("--seed", type=int, default=0, help="of sensors and wind")
    parser.add_argument("--instance", type=int, default=9, help="shifts all ports")
    row = fly(parser.parse_args())
    row["misses"] = misses(row)
    print(json.dumps(row, indent=2))
    return 1 if row["misses"] else 0


if __name__ == "__main__":
    sys.exit(main())
