"""Several vehicles in one loop: each with its system id, its ports and its autopilot."""

import pytest

from flightsim.mavlink.links import network_links
from flightsim.testbench import Testbench, TestbenchCfg, TestbenchError
from flightsim.vehicles import airframe_by_name
from tests.flightsim.handmade import empty_scene

IRIS = airframe_by_name("iris")


def test_each_vehicle_answers_by_its_own_system_id_and_flies_by_its_own_commands():
    cfg = TestbenchCfg(speed="max", instance=4)
    airframes = [IRIS, airframe_by_name("hummingbird")]
    with Testbench(empty_scene(), cfg, airframes=airframes, has_network=False) as bench:
        clients = [each.connect() for each in bench.vehicles]
        for client in clients:
            bench.observers.append(lambda c=client: c.update(bench.plant.time_us))
        first, second = bench.vehicles
        bench.run(10.0, until=lambda: all(b.autopilot.prearm.is_ok for b in bench.vehicles))
        assert [client.telemetry.system_id for client in clients] == [5, 6]
        assert [b.autopilot.parameters["MAV_SYS_ID"] for b in bench.vehicles] == [5, 6]
        assert second.autopilot.takeoff(bench.scene.altitude_m + 3.0).is_accepted
        assert second.autopilot.arm().is_accepted
        bench.run(6.0)
        assert not first.autopilot.is_armed
        assert first.plant.truth.position_enu_m[2] < 0.5
        assert second.plant.truth.position_enu_m[2] > 1.5
        assert first.plant.time_us == second.plant.time_us == bench.plant.time_us


def test_all_vehicles_of_a_world_speak_to_one_ground_station_as_those_of_px4():
    names = [
        [link.name for link in network_links(i, "127.0.0.1", first_instance=2)] for i in (2, 3)
    ]
    assert names[0][:2] == ["udp:18572->14552", "udp:14582->14542"]
    assert names[1][:2] == ["udp:18573->14552", "udp:14583->14543"]


def test_each_vehicle_asks_for_the_ports_of_its_instance_and_the_first_ones_ground_station(
    monkeypatch,
):
    asked = []

    def network(instance, _bind, *, first_instance, **_):
        asked.append((instance, first_instance))
        return []

    monkeypatch.setattr("flightsim.testbench.own_stack.network_links", network)
    with Testbench(empty_scene(), TestbenchCfg(instance=4), airframes=[IRIS] * 3):
        assert asked == [(4, 4), (5, 4), (6, 4)]


def test_what_several_vehicles_cannot_be_is_refused_in_a_line():
    with pytest.raises(TestbenchError, match="vehicles 2 are our autopilot's, and px4 flies"):
        Testbench(empty_scene(), TestbenchCfg(autopilot="px4"), airframes=[IRIS] * 2)
    with pytest.raises(TestbenchError, match="vehicles 3 from instance 98 on reach instance 100"):
        Testbench(empty_scene(), TestbenchCfg(instance=98), airframes=[IRIS] * 3)
