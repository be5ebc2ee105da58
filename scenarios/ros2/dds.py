"""Topics and services over DDS, which ROS 2's default installations speak, by Cyclone DDS.

ROS 2 adds conventions to DDS: names of topics and types, and for services a header with the caller.
This module follows them. Samples arrive here as bytes of CDR already, encoded by rosbags, so they
pass Cyclone's Python types as they are. Encoding each message by Cyclone's own Python code would be
a second definition of every type.
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
from scenarios.ros2.untyped_endpoints import require_known_version, without_structure

_LOG = logging.getLogger(__name__)
_MOST_AT_ONCE = 100
_HEADER_BYTES = 4
"""Bytes in front of CDR that name its encoding."""
_CALLER = struct.Struct("<Qq")
"""Client and number of a request, which rmw_cyclonedds_cpp puts behind that header."""
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
"""Settings of Cyclone DDS. Discovery is by multicast and also by asking this machine, because nodes
with ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST have no multicast."""
_LOOPBACK, _ANY = "127.0.0.1", "0.0.0.0"  # noqa: S104  # compared with, not bound to


class DdsTransport:
    """Transport over DDS: a participant in a domain."""

    def __init__(self, domain: int, address: str, definitions: Definitions) -> None:
        """Join a domain.

        Args:
            domain: Number of the domain, as in ROS_DOMAIN_ID.
            address: Address of the interface to use; 0.0.0.0 leaves the choice to Cyclone DDS.
            definitions: Definitions of the messages, from which types are made.

        Raises:
            TransportError: If the library is not installed or of another version, or if it refuses
                the domain or the address.
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
        # Cyclone has no list of its sockets; they are those that appear meanwhile.
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
        """Offer a topic; see `Transport.outlet`."""
        # ROS 2 puts "rt" before topics, "rq" and "rr" before requests and replies.
        return self._writer(f"rt{topic}", self._types.message(kind.name), qos, kind.type_hash)

    def inlet(self, topic: str, kind: Kind, qos: Qos) -> Inlet:
        """Subscribe to a topic; see `Transport.inlet`."""
        return self._reader(f"rt{topic}", self._types.message(kind.name), qos, kind.type_hash)

    def service(self, name: str, kind: Kind) -> Service:
        """Offer a service as rmw_cyclonedds_cpp calls it; clients of other rmws cannot call it."""
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
        """Leave the domain, and free its sockets."""
        # Cyclone's binding ends an entity in its destructor, which may come late on its own.
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
        """True if anybody subscribes, as of a tenth of a second ago at most."""
        return self._is_matched()

    def send(self, data: bytes) -> None:
        """Publish a message; it is lost if a slow reader would make it wait."""
        from cyclonedds.core import DDSException

        try:
            self._writer.write(sample(self._writer.data_type, data))
        except DDSException as error:
            _LOG.debug("message lost: %s", error.msg)


@dataclass(frozen=True, slots=True)
class _DdsInlet:
    _reader: Any

    def take(self) -> Sequence[bytes]:
        """Return the messages that have arrived since the last call."""
        taken = self._reader.take(_MOST_AT_ONCE)
        # Samples without bytes only say that a writer has gone.
        return [each.cdr for each in taken if hasattr(each, "cdr")]


@dataclass(frozen=True, slots=True)
class _DdsService:
    """Requests and replies with the caller in front, in the form of rmw_cyclonedds_cpp."""

    _requests: _DdsInlet
    _replies: _DdsOutlet

    def take(self) -> Sequence[Request]:
        """Return the requests that have arrived since the last call."""
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
    """Return the DDS policies of a profile; no writer waits for a slow reader."""
    from cyclonedds.core import Policy
    from cyclonedds.qos import Qos as Policies

    reliability = Policy.Reliability
    durability = Policy.Durability
    return Policies(
        reliability.Reliable(max_blocking_time=0) if qos.is_reliable else reliability.BestEffort,
        durability.TransientLocal if qos.is_latched else durability.Volatile,
        Policy.History.KeepLast(qos.depth),
        Policy.DataRepresentation(use_cdrv0_representation=True),
        # Where ROS 2 since Iron looks for the hash of a topic's type.
        *([Policy.Userdata(f"typehash={type_hash};".encode())] if type_hash else []),
    )


def _config(address: str) -> str:
    """Return the configuration of Cyclone DDS for an address."""
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
