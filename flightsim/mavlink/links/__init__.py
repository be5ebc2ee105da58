"""Transports for MAVLink bytes: UDP, TCP, serial and in-process.

Links never block, and no partner can delay or stop the flight. What a transport cannot take is
dropped, as a radio would drop it; the protocols above repeat.
"""

from flightsim.mavlink.links.in_process import InProcessClient, InProcessLink
from flightsim.mavlink.links.link import Link, LinkError, PortInUseError, is_loopback
from flightsim.mavlink.links.network import local_ports, network_links
from flightsim.mavlink.links.serial import SerialLine, SerialLink
from flightsim.mavlink.links.tcp import TcpServerLink
from flightsim.mavlink.links.udp import UdpLink
from flightsim.mavlink.links.udp_out import OutAddress, UdpOutLink

__all__ = [
    "InProcessClient",
    "InProcessLink",
    "Link",
    "LinkError",
    "OutAddress",
    "PortInUseError",
    "SerialLine",
    "SerialLink",
    "TcpServerLink",
    "UdpLink",
    "UdpOutLink",
    "is_loopback",
    "local_ports",
    "network_links",
]
