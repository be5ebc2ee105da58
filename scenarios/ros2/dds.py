"""Topics and services over DDS as the default installations of ROS 2 speak it, by Cyclone DDS.

Samples are CDR already, and pass Cyclone's Python types as they are.
"""

from __future__ import annotations

import logging
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from scenarios.ros2.idl import Definitions, IdlTypes, sample
from scenarios.ros2.loopback import confine, open_sockets
from scenarios.ros2.polling import Lately
from scenarios.ros2.transport import (
    STATE,
    Inlet,
    Kind,
    Outlet,
    Qos,
    Request,
    Service,
    TransportError,
)
from scenarios.ros2.untyped import require_known_version, without_structure

_LOG = logging.getLogger(__name__)
_MOST_AT_ONCE = 100
_HEADER_BYTES = 4
"""Bytes in front of CDR that name its encoding."""
_CALLER = struct.Struct("<Qq")
"""What rmw_cyclonedds_cpp has between that header and a request or a reply: client, number."""
_CONFIG = """
<CycloneDDS><Domain Id="any">
  <General>
    <Interfaces>{interface}</Interfaces>
    <AllowMulticast>{multicast}</AllowMulticast>
  </General>
  <Discovery>
    <ParticipantIndex>auto</ParticipantIndex>
    <MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>
    <Peers><Peer address="localhost"/></Peers>
  </Discovery>
  <Tracing><Verbosity>none</Verbosity></Tracing>
</Domain></CycloneDDS>
"""
"""Discovery by multicast, and by asking this machine, as nodes with
ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST have no multicast."""
_LOOPBACK, _ANY = "127.0.0.1", "0.0.0.0"  # noqa: S104  # compared with, not bound to


class DdsTransport:
    """A participant in a DDS domain."""

    def __init__(self, domain: int, address: str, definitions: Definitions) -> None:
        """Join a domain.

        Args:
            domain: Its number, as in ROS_DOMAIN_ID.
            address: Address of the interface to use; 0.0.0.0 leaves the choice to Cyclone DDS.
            definitions: Definitions of the messages.

        Raises:
            TransportError: If the library is not installed, or refuses.
        """
        try:
            from cyclonedds.core import DDSException
            from cyclonedds.domain import Domain, DomainParticipant
        except ImportError:
            raise TransportError(
                "needs cyclonedds, which is not installed; valid: pip install 'aeroscene[ros2]'"
            ) from None
        require_known_version()
        self._endpoints: list[Any] = []
        self._types = IdlTypes(definitions)
        before = open_sockets()
        try:
            self._domain = Domain(domain, _config(address))
            self._participant = DomainParticipant(domain)
        except DDSException as error:
            raise TransportError(
                f"cannot join domain {domain} by address {address}: {error.msg}"
            ) from None
        if address == _LOOPBACK:
            _keep_to_loopback(open_sockets() - before)

    def outlet(self, topic: str, kind: Kind, qos: Qos) -> Outlet:
        """Offer a topic."""
        return self._writer(f"rt{topic}", self._types.message(kind.name), qos, kind.type_hash)

    def inlet(self, topic: str, kind: Kind, qos: Qos) -> Inlet:
        """Subscribe to a topic."""
        return self._reader(f"rt{topic}", self._types.message(kind.name), qos, kind.type_hash)

    def service(self, name: str, kind: Kind) -> Service:
        """Offer a service, as rmw_cyclonedds_cpp calls it."""
        request = self._types.half(kind.name, "Request")
        response = self._types.half(kind.name, "Response")
        requests = self._reader(f"rq{name}Request", request, STATE, "")
        replies = self._writer(f"rr{name}Reply", response, STATE, "")
        return _DdsService(requests, replies)

    def _writer(self, name: str, kind: type, qos: Qos, type_hash: str) -> _DdsOutlet:
        from cyclonedds.pub import DataWriter
        from cyclonedds.topic import Topic

        topic = Topic(self._participant, name, kind)
        with without_structure(topic):
            writer = DataWriter(self._participant, topic, qos=_dds_qos(qos, type_hash))
        self._endpoints.append(writer)
        return _DdsOutlet(writer)

    def _reader(self, name: str, kind: type, qos: Qos, type_hash: str) -> _DdsInlet:
        from cyclonedds.sub import DataReader
        from cyclonedds.topic import Topic

        topic = Topic(self._participant, name, kind)
        with without_structure(topic):
            reader = DataReader(self._participant, topic, qos=_dds_qos(qos, type_hash))
        self._endpoints.append(reader)
        return _DdsInlet(reader)

    def close(self) -> None:
        """Leave the domain: an entity ends with its last reference, or when it is told to."""
        for entity in (*self._endpoints, self._participant, self._domain):
            entity.__del__()
        self._endpoints.clear()


@dataclass(slots=True)
class _DdsOutlet:
    """A writer of samples that are CDR already."""

    _writer: Any
    _is_matched: Lately

    def __init__(self, writer: Any) -> None:
        self._writer = writer
        self._is_matched = Lately(lambda: bool(writer.get_matched_subscriptions()))

    @property
    def is_heard(self) -> bool:
        """Whether anybody subscribes."""
        return self._is_matched()

    def send(self, data: bytes) -> None:
        """Publish a message; it is lost where a reader is so slow that it would have to wait."""
        from cyclonedds.core import DDSException

        try:
            self._writer.write(sample(self._writer.data_type, data))
        except DDSException as error:
            _LOG.debug("message lost: %s", error.msg)


@dataclass(frozen=True, slots=True)
class _DdsInlet:
    _reader: Any

    def take(self) -> Sequence[bytes]:
        """Messages that have come; what says that a writer has gone is none."""
        taken = self._reader.take(_MOST_AT_ONCE)
        return [each.cdr for each in taken if hasattr(each, "cdr")]


@dataclass(frozen=True, slots=True)
class _DdsService:
    """Requests and replies with the client's number in front, as rmw_cyclonedds_cpp has them."""

    _requests: _DdsInlet
    _replies: _DdsOutlet

    def take(self) -> Sequence[Request]:
        """Requests that have come since the last call."""
        start = _HEADER_BYTES + _CALLER.size
        return [
            Request(
                data=data[:_HEADER_BYTES] + data[start:],
                reply=partial(self._reply, data[_HEADER_BYTES:start]),
            )
            for data in self._requests.take()
            if len(data) >= start
        ]

    def _reply(self, caller: bytes, data: bytes) -> None:
        self._replies.send(data[:_HEADER_BYTES] + caller + data[_HEADER_BYTES:])


def _dds_qos(qos: Qos, type_hash: str) -> Any:
    """The policies of a profile; no writer waits for a slow reader."""
    from cyclonedds.core import Policy
    from cyclonedds.qos import Qos as Policies

    reliability = Policy.Reliability
    durability = Policy.Durability
    return Policies(
        reliability.Reliable(max_blocking_time=0) if qos.is_reliable else reliability.BestEffort,
        durability.TransientLocal if qos.is_latched else durability.Volatile,
        Policy.History.KeepLast(qos.depth),
        Policy.DataRepresentation(use_cdrv0_representation=True),
        *([Policy.Userdata(f"typehash={type_hash};".encode())] if type_hash else []),
    )


def _config(address: str) -> str:
    """Configuration of Cyclone DDS for an address."""
    if address == _ANY:
        return _CONFIG.format(
            interface='<NetworkInterface autodetermine="true"/>', multicast="true"
        )
    interface = f'<NetworkInterface address="{address}" multicast="true"/>'
    # On loopback, multicast is for discovery alone.
    multicast = "spdp" if address == _LOOPBACK else "true"
    return _CONFIG.format(interface=interface, multicast=multicast)


def _keep_to_loopback(descriptors: set[int]) -> None:
    try:
        confine(descriptors)
    except OSError as error:
        _LOG.warning(
            "ROS 2: the system does not bind sockets to loopback (%s); they send there only, and "
            "receive on every interface",
            error.strerror,
        )
