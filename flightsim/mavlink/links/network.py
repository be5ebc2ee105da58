"""All links of a testbench to clients outside its process."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from flightsim.mavlink.links.link import Link
from flightsim.mavlink.links.serial import SerialLine, SerialLink
from flightsim.mavlink.links.tcp import TcpServerLink
from flightsim.mavlink.links.udp import UdpLink
from flightsim.mavlink.links.udp_out import OutAddress, UdpOutLink
from flightsim.mavlink.signing import Signing


@dataclass(frozen=True, slots=True)
class LocalPorts:
    """Ports that a vehicle listens on, to which a client elsewhere speaks first."""

    ground_station: int
    sdk: int
    tcp: tuple[int, ...]


def local_ports(instance: int) -> LocalPorts:
    """Return the ports of a vehicle by its number, as in PX4's and ArduPilot's simulators."""
    tcp = tuple(port + 10 * instance for port in (5760, 5762, 5763))
    return LocalPorts(18570 + instance, 14580 + instance, tcp)


def network_links(
    instance: int,
    bind: str,
    *,
    first_instance: int | None = None,
    serial_line: SerialLine | None = None,
    outs: Sequence[OutAddress] = (),
    is_lockstep: bool = False,
    signing: Signing | None = None,
) -> list[Link]:
    """Return the links to clients: ports of both stacks' simulators, and a serial device if any.

    UDP goes to 14550 and 14540 as with PX4; TCP servers are on 5760, 5762 and 5763 as with
    ArduPilot. Vehicles of one world speak to one ground station, as PX4's do: that of the first
    vehicle.

    Args:
        instance: Number of the vehicle, which shifts all ports.
        bind: Address that the ports listen on.
        first_instance: Number of the first vehicle of the same world; None if it is this one.
        serial_line: Serial device; None for none.
        outs: Addresses elsewhere to which the vehicle speaks first.
        is_lockstep: True runs protocol timeouts in simulated time.
        signing: Key and timestamps that the links share; None never signs.
    """
    udp = partial(UdpLink, bind_address=bind, is_lockstep=is_lockstep, signing=signing)
    tcp = partial(TcpServerLink, bind_address=bind, is_lockstep=is_lockstep, signing=signing)
    ground_station = 14550 + (instance if first_instance is None else first_instance)
    ports = local_ports(instance)
    links: list[Link] = [
        udp(local_port=ports.ground_station, remote_port=ground_station),
        udp(local_port=ports.sdk, remote_port=14540 + instance, profile="onboard"),
        *(tcp(port=port) for port in ports.tcp),
    ]
    links += [UdpOutLink(out, is_lockstep=is_lockstep, signing=signing) for out in outs]
    if serial_line is not None:
        links.append(SerialLink(serial_line, is_lockstep=is_lockstep, signing=signing))
    return links
