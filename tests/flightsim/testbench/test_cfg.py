"""Settings of a testbench: addresses to speak to first."""

import pytest

from flightsim.mavlink.links import UdpOutLink, local_ports, network_links
from flightsim.testbench import TestbenchCfg, TestbenchError


def test_addresses_to_speak_to_first_become_links_of_each_vehicle():
    cfg = TestbenchCfg(out=("udp:127.0.0.1:14551", "udp:localhost:14552"))
    links = network_links(0, cfg.bind, outs=cfg.out_addresses)
    named = [link.name for link in links if isinstance(link, UdpOutLink)]
    assert named == ["udp:127.0.0.1:14551", "udp:localhost:14552"]


def test_an_address_that_is_none_is_refused_before_anything_is_built():
    with pytest.raises(TestbenchError, match=r"out '10\.0\.0\.1:14550' is no address; valid: udp:"):
        TestbenchCfg(out=("10.0.0.1:14550",))


def test_another_flight_stack_has_no_address_of_ours_to_speak_to():
    with pytest.raises(TestbenchError, match=r"out udp:127\.0\.0\.1:1 is our autopilot's"):
        TestbenchCfg(autopilot="px4", out=("udp:127.0.0.1:1",))


def test_the_ports_that_a_remote_client_addresses_go_with_the_instance():
    ports = local_ports(3)
    assert (ports.ground_station, ports.sdk, ports.tcp) == (18573, 14583, (5790, 5792, 5793))
