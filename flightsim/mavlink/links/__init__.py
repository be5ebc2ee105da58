"""Ways for MAVLink bytes to come and go: UDP, TCP and in process.

Nothing here blocks, and nothing that a partner does, or stops doing, reaches the flight.
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
