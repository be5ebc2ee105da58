"""How rmw_zenoh names things: keys of topics, tokens of the graph, what is attached to messages.

Source: https://github.com/ros2/rmw_zenoh, docs/design.md and liveliness_utils.cpp.
"""

from __future__ import annotations

import hashlib
import struct
import time
from typing import Literal

from scenarios.ros2.transport import Kind, Qos

Entity = Literal["MP", "MS", "SS"]
"""Publisher, subscription, server of a service."""
NODE = "aeroscene"
_GRAPH = "@ros2_lv"
_NONE = "%"
"""An empty enclave, and a namespace that is the root."""
_BEST_EFFORT, _TRANSIENT_LOCAL = "2", "1"
_DEFAULT_DEPTH = 42
"""Depth that rmw_zenoh leaves out."""
_GID_BYTES = 16
_ATTACHMENT = struct.Struct(f"<qqB{_GID_BYTES}s")
"""Number of the message, time in ns, and the sender's id with its length."""


def topic_key(domain: int, name: str, kind: Kind) -> str:
    """Key on which messages of a topic, or requests to a service, travel."""
    return f"{domain}/{name.strip('/')}/{kind.dds_name}/{kind.type_hash}"


def node_token(domain: int, session_id: str) -> str:
    """Token by which our node is in the graph."""
    return "/".join((_GRAPH, str(domain), session_id, "0", "0", "NN", _NONE, _NONE, NODE))


def entity_token(
    domain: int, session_id: str, number: int, entity: Entity, name: str, kind: Kind, qos: Qos
) -> str:
    """Token by which a publisher, a subscription or a service of our node is in the graph."""
    about = (entity, _NONE, _NONE, NODE, name.replace("/", _NONE), kind.dds_name, kind.type_hash)
    start = (_GRAPH, str(domain), session_id, "0", str(number))
    return "/".join((*start, *about, qos_words(qos)))


def qos_words(qos: Qos) -> str:
    """A profile as tokens have it: what is rmw_zenoh's default is left out."""
    reliability = "" if qos.is_reliable else _BEST_EFFORT
    durability = _TRANSIENT_LOCAL if qos.is_latched else ""
    depth = "" if qos.depth == _DEFAULT_DEPTH else str(qos.depth)
    return f"{reliability}:{durability}:,{depth}:,:,:,,"


def gid(token: str) -> bytes:
    """An id of its own for each token; rmw_zenoh hashes otherwise, and compares ids alone."""
    return hashlib.blake2b(token.encode(), digest_size=_GID_BYTES).digest()


def attachment(number: int, sender: bytes) -> bytes:
    """What goes with a message: its number, counted by the sender, and the time now."""
    return _ATTACHMENT.pack(number, time.time_ns(), _GID_BYTES, sender)


def read_attachment(data: bytes) -> tuple[int, bytes]:
    """Number and sender of what was attached.

    Raises:
        struct.error: If it is none.
    """
    number, _, _, sender = _ATTACHMENT.unpack(data)
    return number, sender
