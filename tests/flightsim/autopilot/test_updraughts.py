"""An updraught carries a part of the weight: neither ground nor the end of the wind."""

import math

from flightsim.environment.wind import WindCfg
from flightsim.sensors.failure import Failure
from tests.flightsim.autopilot.bench import Bench


def room_below_m(bench):
    return bench.plant._controller["room_below_m"]


def test_an_updraught_takes_neither_the_hold_nor_the_flight():
    bench = Bench().take_off(4.0)
    place_enu_m = bench.plant.truth.position_enu_m[:2]
    bench.plant.wind = WindCfg(speed_mps=8.0, from_deg=270.0, up_mps=3.0)
    away_m = []
    for _ in range(300):
        bench.step()
        assert not bench.pilot._vehicle.is_landed
        away_m.append(math.dist(bench.plant.truth.position_enu_m[:2], place_enu_m))
    assert max(away_m) < 1.0
    assert away_m[-1] < 0.2


def test_it_knows_how_much_is_free_below():
    bench = Bench()
    assert room_below_m(bench) < 0.05
    bench.take_off(4.0)
    assert abs(room_below_m(bench) - 4.0) < 0.2
    bench.plant.failures.fail_sensor("range", Failure.OFF)
    bench.run(1.0)
    assert room_below_m(bench) == 0.0
