"""Topics and services over Zenoh, by the conventions of rmw_zenoh.

Nodes of rmw_zenoh find each other through a router on this machine, the program rmw_zenohd. If no
router runs yet, our session is the router itself, so that users need not start one.
"""

from __future__ import annotations

import itertools
import json
import logging
import struct
from collections.abc import Sequence
from functools import partial
from typing import Any

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
from scenarios.ros2.zenoh_names import (
    Entity,
    attachment,
    entity_token,
    gid,
    node_token,
    read_attachment,
    topic_key,
)

_LOG = logging.getLogger(__name__)
PORT = 7447
"""TCP port of the router that rmw_zenoh looks for on this machine."""
_MOST_WAITING = 100  # messages in a queue; older ones are dropped


class ZenohTransport:
    """Transport over Zenoh: a session with one node in it."""

    def __init__(self, domain: int, address: str, instance: int) -> None:
        """Listen as the router of this machine, or join the router that runs.

        Args:
            domain: Number of the domain, as in ROS_DOMAIN_ID.
            address: Address to listen on.
            instance: Number that is added to the port.

        Raises:
            TransportError: If the library is not installed, or the port is taken by something that
                is no router.
        """
        try:
            import zenoh
        except ImportError:
            raise TransportError(
                "needs eclipse-zenoh, which is not installed; valid: pip install 'aeroscene[ros2]'"
            ) from None
        self._zenoh, self._domain = zenoh, domain
        self._session = _open(zenoh, address, PORT + instance)
        self._id = str(self._session.zid())
        self._numbers = itertools.count(1)
        self._declared: list[Any] = []
        self._token(node_token(domain, self._id))

    def outlet(self, topic: str, kind: Kind, qos: Qos) -> Outlet:
        """Offer a topic; see `Transport.outlet`."""
        token = self._enter("MP", topic, kind, qos)
        key = topic_key(self._domain, topic, kind)
        options = {
            "encoding": self._zenoh.Encoding.APPLICATION_CDR,
            # Blocking, the alternative, would let a slow node delay the flight.
            "congestion_control": self._zenoh.CongestionControl.DROP,
            "reliability": self._zenoh.Reliability.RELIABLE
            if qos.is_reliable
            else self._zenoh.Reliability.BEST_EFFORT,
        }
        if not qos.is_latched:
            publisher = self._keep(self._session.declare_publisher(key, **options))
            return _ZenohOutlet(publisher, gid(token), lambda: publisher.matching_status.matching)
        from zenoh.ext import CacheConfig, declare_advanced_publisher

        # "Transient local" is a cache, from which late subscribers ask for the last messages.
        publisher = declare_advanced_publisher(
            self._session,
            key,
            cache=CacheConfig(qos.depth),
            publisher_detection=True,
            **options,
        )
        return _ZenohOutlet(self._keep(publisher), gid(token), lambda: True)

    def inlet(self, topic: str, kind: Kind, qos: Qos) -> Inlet:
        """Subscribe to a topic, of which only the newest messages wait; see `Transport.inlet`."""
        self._enter("MS", topic, kind, qos)
        queue = self._zenoh.handlers.RingChannel(_MOST_WAITING)
        key = topic_key(self._domain, topic, kind)
        return _ZenohInlet(self._keep(self._session.declare_subscriber(key, queue)))

    def service(self, name: str, kind: Kind) -> Service:
        """Offer a service; see `Transport.service`."""
        self._enter("SS", name, kind, STATE)
        queue = self._zenoh.handlers.RingChannel(_MOST_WAITING)
        key = topic_key(self._domain, name, kind)
        server = self._session.declare_queryable(key, queue, complete=True)
        return _ZenohService(self._keep(server), key, self._zenoh.Encoding.APPLICATION_CDR)

    def _enter(self, entity: Entity, name: str, kind: Kind, qos: Qos) -> str:
        """Announce a topic or a service in the graph, and return its token."""
        number = next(self._numbers)
        token = entity_token(self._domain, self._id, number, entity, name, kind, qos)
        self._token(token)
        return token

    def _token(self, token: str) -> None:
        self._keep(self._session.liveliness().declare_token(token))

    def _keep(self, declared: Any) -> Any:
        """Keep a declared entity, because it ends with its last reference."""
        self._declared.append(declared)
        return declared

    def close(self) -> None:
        """Leave the graph, and free the port."""
        self._declared.clear()
        self._session.close()


class _ZenohOutlet:
    def __init__(self, publisher: Any, sender: bytes, is_matched: Any) -> None:
        self._publisher, self._sender = publisher, sender
        self._is_matched = Lately(is_matched)
        self._n_sent = 0

    @property
    def is_heard(self) -> bool:
        """True if anybody subscribes; always true for a latched topic, which fills its cache."""
        return self._is_matched()

    def send(self, data: bytes) -> None:
        """Publish a message; it is dropped if the connection is full."""
        self._n_sent += 1
        self._publisher.put(data, attachment=attachment(self._n_sent, self._sender))


class _ZenohInlet:
    def __init__(self, subscriber: Any) -> None:
        self._subscriber = subscriber

    def take(self) -> Sequence[bytes]:
        """Return the messages that have arrived since the last call."""
        return [sample.payload.to_bytes() for sample in _waiting(self._subscriber)]


class _ZenohService:
    """A queryable of Zenoh; number and id of a request go back with its reply."""

    def __init__(self, queryable: Any, key: str, encoding: Any) -> None:
        self._queryable, self._key, self._encoding = queryable, key, encoding

    def take(self) -> Sequence[Request]:
        """Return the requests since the last call; queries that ROS did not send are dropped."""
        found: list[Request] = []
        for query in _waiting(self._queryable):
            # Any program may query the key; ROS always sends a payload and an attachment.
            if query.payload is None or query.attachment is None:
                continue
            try:
                number, sender = read_attachment(query.attachment.to_bytes())
            except struct.error as error:
                _LOG.debug("request dropped: %s", error)
                continue
            data = query.payload.to_bytes()
            found.append(Request(data=data, reply=partial(self._reply, query, number, sender)))
        return found

    def _reply(self, query: Any, number: int, sender: bytes, data: bytes) -> None:
        with query:
            query.reply(
                self._key, data, encoding=self._encoding, attachment=attachment(number, sender)
            )


def _waiting(handler: Any) -> list[Any]:
    """Return everything that waits in a queue, without blocking."""
    found: list[Any] = []
    while (each := handler.try_recv()) is not None:
        found.append(each)
    return found


def _open(zenoh: Any, address: str, port: int) -> Any:
    """Open a session as the router on a port, or as a peer of the router that has it."""
    own = f"tcp/{address}:{port}"
    try:
        return zenoh.open(_config(zenoh, mode="router", listen=[own], connect=[]))
    except zenoh.ZError as error:
        _LOG.debug("no router of ours at %s: %s", own, error)
    try:
        beside = [f"tcp/127.0.0.1:{port}"]
        return zenoh.open(_config(zenoh, mode="peer", listen=[f"tcp/{address}:0"], connect=beside))
    except zenoh.ZError as error:
        raise TransportError(
            f"cannot listen at {own}, nor find a router there: {error}; valid: a free port, by "
            "another --instance"
        ) from None


def _config(zenoh: Any, *, mode: str, listen: Sequence[str], connect: Sequence[str]) -> Any:
    """Return settings like those of rmw_zenoh's sessions and router: gossip without multicast."""
    config = zenoh.Config()
    for key, value in {
        "mode": mode,
        "listen/endpoints": listen,
        "connect/endpoints": connect,
        # A port that some other program has must be refused soon, not waited for.
        "connect/timeout_ms": 2000,
        "connect/exit_on_failure": True,
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": True,
        "timestamping/enabled": True,
    }.items():
        config.insert_json5(key, json.dumps(value))
    return config
