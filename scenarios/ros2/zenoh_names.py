"""Conventions of rmw_zenoh: keys of topics, tokens of the graph, attachments of messages.

Zenoh itself knows keys and bytes only. rmw_zenoh puts domain, name, type and hash of a topic into
its key, and announces nodes, topics and services by liveliness tokens, from which other nodes build
the graph of ROS. A key or a token that differs in one letter is not found by any node.

Source: https://github.com/ros2/rmw_zenoh, docs/design.md and liveliness_utils.cpp.
"""

from __future__ import annotations

import hashlib
import struct
import time
from typing import Literal

from scenarios.ros2.transport import Kind, Qos

Entity = Literal["MP", "MS", "SS"]
"""Kind of an entity: publisher, subscription, or server of a service."""
NODE = "aeroscene"
_GRAPH = "@ros2_lv"
_NONE = "%"
"""Sign for an empty enclave, and for the root as the namespace."""
_BEST_EFFORT, _TRANSIENT_LOCAL = "2", "1"
_DEFAULT_DEPTH = 42
"""Default depth of rmw_zenoh, which its tokens leave out."""
_GID_BYTES = 16
_ATTACHMENT = struct.Struct(f"<qqB{_GID_BYTES}s")
"""Form of an attachment: number of the message, time in ns, and the sender's id with its length."""


def topic_key(domain: int, name: str, kind: Kind) -> str:
    """Return the key of the messages of a topic, or of the requests to a service.

    Args:
        domain: Number of the domain.
        name: Full name of the topic or the service.
        kind: Its type.
    """
    return f"{domain}/{name.strip('/')}/{kind.dds_name}/{kind.type_hash}"


def node_token(domain: int, session_id: str) -> str:
    """Return the token by which our node appears in the graph."""
    return "/".join((_GRAPH, str(domain), session_id, "0", "0", "NN", _NONE, _NONE, NODE))


def entity_token(
    domain: int, session_id: str, number: int, entity: Entity, name: str, kind: Kind, qos: Qos
) -> str:
    """Return the token by which a publisher, subscription or service of ours appears in the graph.

    Args:
        domain: Number of the domain.
        session_id: Id of the Zenoh session.
        number: Number of the entity, different for each of the session.
        entity: Its kind.
        name: Full name of the topic or the service.
        kind: Its type.
        qos: Its quality of service.
    """
    # Slashes part the fields of a token, so those within names become "%".
    about = (entity, _NONE, _NONE, NODE, name.replace("/", _NONE), kind.dds_name, kind.type_hash)
    start = (_GRAPH, str(domain), session_id, "0", str(number))
    return "/".join((*start, *about, qos_words(qos)))


def qos_words(qos: Qos) -> str:
    """Return a profile in the form of tokens, which leave rmw_zenoh's defaults out."""
    # The colons part policies; the empty fields behind are deadline, lifespan and liveliness.
    reliability = "" if qos.is_reliable else _BEST_EFFORT
    durability = _TRANSIENT_LOCAL if qos.is_latched else ""
    depth = "" if qos.depth == _DEFAULT_DEPTH else str(qos.depth)
    return f"{reliability}:{durability}:,{depth}:,:,:,,"


def gid(token: str) -> bytes:
    """Return an id that is different for each token.

    rmw_zenoh computes its ids by another hash, but it only compares ids with each other.
    """
    return hashlib.blake2b(token.encode(), digest_size=_GID_BYTES).digest()


def attachment(number: int, sender: bytes) -> bytes:
    """Return the attachment of a message: its number, the present wall time and the sender.

    Args:
        number: Number of the message, counted by the sender from 1.
        sender: Id of the sender, 16 bytes.
    """
    return _ATTACHMENT.pack(number, time.time_ns(), _GID_BYTES, sender)


def read_attachment(data: bytes) -> tuple[int, bytes]:
    """Return the number and the sender of an attachment.

    Args:
        data: Attachment of a message.

    Raises:
        struct.error: If the bytes are no attachment of rmw_zenoh.
    """
    number, _, _, sender = _ATTACHMENT.unpack(data)
    return number, sender
