"""Settings of a testbench: addresses to speak to first."""

import socket

import pytest

from flightsim.mavlink.links import UdpOutLink, local_ports, network_links
from flightsim.testbench import Testbench, TestbenchCfg, TestbenchError
from tests.flightsim.handmade import empty_scene
from tests.flightsim.mavlink.wire import Wire, named
from tests.instances import free_port, own_instance


def test_addresses_to_speak_to_first_become_links_of_each_vehicle():
    cfg = TestbenchCfg(out=("udp:127.0.0.1:14551", "udp:localhost:14552"))
    links = network_links(0, cfg.bind, outs=cfg.out_addresses)
    named = [link.name for link in links if isinstance(link, UdpOutLink)]
    assert named == ["udp:127.0.0.1:14551", "udp:localhost:14552"]


def test_a_testbench_speaks_first_to_its_addresses():
    port = free_port(socket.SOCK_DGRAM)
    cfg = TestbenchCfg(speed="max", instance=own_instance(), out=(f"udp:127.0.0.1:{port}",))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as station:
        station.bind(("127.0.0.1", port))
        station.settimeout(5.0)
        with Testbench(empty_scene(), cfg) as bench:
            bench.run(2.0)
            wire = Wire()
            while not named(wire.decode(station.recv(2048)), "HEARTBEAT"):
                pass  # A datagram of other messages: without a first word none comes at all.


def test_an_address_that_is_none_is_refused_before_anything_is_built():
    with pytest.raises(TestbenchError, match=r"out '10\.0\.0\.1:14550' is no address; valid: udp:"):
        TestbenchCfg(out=("10.0.0.1:14550",))


def test_another_flight_stack_has_no_address_of_ours_to_speak_to():
    with pytest.raises(TestbenchError, match=r"out udp:127\.0\.0\.1:1 is our autopilot's"):
        TestbenchCfg(autopilot="px4", out=("udp:127.0.0.1:1",))


def test_the_ports_that_a_remote_client_addresses_go_with_the_instance():
    ports = local_ports(3)
    assert (ports.ground_station, ports.sdk, ports.tcp) == (18573, 14583, (5790, 5792, 5793))
