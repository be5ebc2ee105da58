"""Programs that fly one vehicle after the other."""

import gc
import weakref

from flightsim.testbench import Testbench, TestbenchCfg
from flightsim.testbench.ended_vehicles import MOST_WAITING
from tests.flightsim.handmade import empty_scene


def test_few_ended_vehicles_wait_for_the_collector():
    gc.collect()
    gc.disable()  # As if each had lived so long that the collector leaves it alone.
    try:
        plants = []
        for _ in range(3 * MOST_WAITING):
            with Testbench(empty_scene(), TestbenchCfg(), has_network=False) as bench:
                plants.append(weakref.ref(bench.plant))
            assert sum(plant() is not None for plant in plants) <= MOST_WAITING + 1
    finally:
        gc.enable()


def test_a_vehicle_that_has_ended_can_still_be_looked_at():
    kept = []
    for _ in range(MOST_WAITING + 1):
        with Testbench(empty_scene(), TestbenchCfg(), has_network=False) as bench:
            bench.run(0.1)
        kept.append(bench)
    assert {each.plant.time_us for each in kept} == {100_000}
