"""What every link offers, and how a port that cannot be had is reported."""

from __future__ import annotations

import errno
import selectors
import socket
from collections.abc import Callable, Sequence
from typing import Literal, Protocol

from flightsim.mavlink.channel import Channel

MAX_PARTNERS = 8
"""Partners of one link at a time: the price of a tick stays bounded."""


class LinkError(OSError):
    """A link cannot be opened."""


class PortInUseError(LinkError):
    """Another program, or another instance, has the port."""


class Link(Protocol):
    """A way for bytes to come and go, with a channel for each partner."""

    @property
    def name(self) -> str:
        """What the link is called in messages to people."""
        ...

    @property
    def channels(self) -> Sequence[Channel]:
        """Partners at present."""
        ...

    def open(self, selector: selectors.BaseSelector, simulated_us: Callable[[], int], /) -> None:
        """Take the port; register sockets with their reading functions as data."""
        ...

    def close(self) -> None:
        """Give the port back. Closing twice is fine."""
        ...


def bind(transport: socket.socket, kind: Literal["UDP", "TCP"], address: str, port: int) -> None:
    """Bind a socket, or close it and say in one line why that failed and what to do.

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
