"""Transports for MAVLink bytes: UDP, TCP and in-process.

Links never block, and no partner can delay or stop the flight.
"""

from flightsim.mavlink.links.in_process import InProcessClient, InProcessLink
from flightsim.mavlink.links.link import Link, LinkError, PortInUseError
from flightsim.mavlink.links.tcp import TcpServerLink
from flightsim.mavlink.links.udp import UdpLink

__all__ = [
    "InProcessClient",
    "InProcessLink",
    "Link",
    "LinkError",
    "PortInUseError",
    "TcpServerLink",
    "UdpLink",
]
