"""Interface of all links, and errors for ports that cannot be opened."""

from __future__ import annotations

import errno
import ipaddress
import selectors
import socket
from collections.abc import Callable, Sequence
from typing import Literal, Protocol

from flightsim.mavlink.channel import Channel

MAX_PARTNERS = 8
"""Most partners of one link at a time, which bounds the cost of a tick."""


class LinkError(OSError):
    """A link could not be opened."""


class PortInUseError(LinkError):
    """The port is in use by another program or instance."""


class Link(Protocol):
    """Transport with one channel per partner."""

    @property
    def name(self) -> str:
        """Name of the link in messages to people."""
        ...

    @property
    def channels(self) -> Sequence[Channel]:
        """Present partners."""
        ...

    def open(self, selector: selectors.BaseSelector, simulated_us: Callable[[], int], /) -> None:
        """Open the port, and register each socket with its reading function as data.

        Args:
            selector: Selector that the server polls.
            simulated_us: Simulated time, for links in lockstep.

        Raises:
            LinkError: If the port cannot be opened.
        """
        ...

    def close(self) -> None:
        """Release the port. Closing twice is fine."""
        ...


def is_loopback(address: str) -> bool:
    """Return true if an IP address is a loopback one, which no other machine hears."""
    return ipaddress.ip_address(address).is_loopback


def bind(transport: socket.socket, kind: Literal["UDP", "TCP"], address: str, port: int) -> None:
    """Bind a socket, or close it and raise an error that says why and what to do.

    Args:
        transport: The socket.
        kind: Name of the protocol in messages.
        address: Address of this machine.
        port: Port number.

    Raises:
        PortInUseError: If the port is taken.
        LinkError: If the address is not one of this machine's, or the port needs privileges.
    """
    try:
        transport.bind((address, port))
    except (OSError, OverflowError) as error:
        transport.close()
        if getattr(error, "errno", None) == errno.EADDRINUSE:
            raise PortInUseError(
                f"{kind} port {port} on {address} is in use: stop the program that has it,"
                " or choose other ports with another --instance"
            ) from error
        raise LinkError(f"cannot open {kind} port {port} on {address}: {error}") from error
