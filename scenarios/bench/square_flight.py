"""The flight of the benchmarks of speed: a climb above everything, then a square."""

from __future__ import annotations

from flightsim.autopilot.modes import LandedState
from flightsim.simulator import TICK_US
from flightsim.testbench import Testbench
from scenarios.bench.configs import BenchError

_READY_S = 30.0
_CLEARANCE_M = 5.0
"""Height above all roofs, where nothing can be in the way."""
_CLIMB_S = 30.0
_LEG_S = 5.0
_CORNERS_M = ((10.0, 0.0), (10.0, 10.0), (0.0, 10.0), (0.0, 0.0))


def take_off(bench: Testbench) -> None:
    """Wait until all vehicles are ready, and let them climb above the whole scene.

    Args:
        bench: Testbench at its start.

    Raises:
        BenchError: If one does not take off.
    """
    simulator, plant, vehicles = bench.simulator, bench.plant, bench.vehicles
    while not all(each.autopilot.prearm.is_ok for each in vehicles):
        if plant.time_us >= _READY_S * 1e6:
            break  # Arming below then names the reason.
        simulator.run(until_us=plant.time_us + 25 * TICK_US)
    roofs_m = max(o.bbox.p[2] + o.bbox.s[2] / 2 for o in bench.scene.objects)
    altitude_m = bench.scene.altitude_m + roofs_m + _CLEARANCE_M
    for each in vehicles:
        for reply in (each.autopilot.takeoff(altitude_m), each.autopilot.arm()):
            if not reply.is_accepted:
                raise BenchError(f"take-off refused: {reply.reason}")
    simulator.run(until_us=plant.time_us + round(1e6 * _CLIMB_S))
    if any(each.autopilot.landed_state is LandedState.ON_GROUND for each in vehicles):
        raise BenchError("the vehicle did not take off")


def fly_square(bench: Testbench, seconds: float) -> None:
    """Fly from corner to corner, each vehicle in a square of its own.

    Args:
        bench: Testbench whose vehicles are in the air.
        seconds: Simulated seconds.

    Raises:
        BenchError: If a corner is refused.
    """
    plant, vehicles = bench.plant, bench.vehicles
    places_enu_m = [each.plant.estimate.position_enu_m for each in vehicles]
    end_us = plant.time_us + round(seconds * 1e6)
    leg = 0
    while plant.time_us < end_us:
        dx, dy = _CORNERS_M[leg % len(_CORNERS_M)]
        for each, (east, north, up) in zip(vehicles, places_enu_m, strict=True):
            corner = bench.frame.geodetic_from_enu((east + dx, north + dy, up))
            reply = each.autopilot.goto(corner)
            if not reply.is_accepted:
                raise BenchError(f"flight to a corner refused: {reply.reason}")
        # A leg lasts five seconds whether or not the corner is reached: the speed is measured.
        bench.simulator.run(until_us=min(end_us, plant.time_us + round(_LEG_S * 1e6)))
        leg += 1
