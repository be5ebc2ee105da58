"""Endpoints of Cyclone DDS that announce the name of their type, but not its structure.

Since ROS 2 Kilted, Fast DDS announces structures of types that Cyclone DDS 11 considers invalid, so
the two never match. If one side announces no structure, both go by the name, which is how Fast DDS
works with rmw_cyclonedds_cpp. Cyclone's Python binding has no setting for that, because its types
need their structure. The structure is therefore hidden while an endpoint is made: the table of
functions by which the library asks for it is replaced by a copy without these functions.
"""

from __future__ import annotations

import contextlib
import ctypes
from collections.abc import Iterator
from importlib.metadata import version
from typing import Any

from scenarios.ros2.transport import TransportError

# `struct ddsi_sertype_ops` of dds/ddsi/ddsi_sertype.h in Cyclone DDS 11.0: functions, of which
# `type_id`, `type_map` and `type_info` may be null. `ops` is the first member of `ddsi_sertype`.
_KNOWN = "11.0."
_N_FUNCTIONS = 14
_OF_STRUCTURE = (8, 9, 10)
_Functions = ctypes.c_void_p * _N_FUNCTIONS


def require_known_version() -> None:
    """Refuse versions of Cyclone DDS whose memory layout was not checked.

    Raises:
        TransportError: If another version than 11.0 is installed.
    """
    if not (found := version("cyclonedds")).startswith(_KNOWN):
        raise TransportError(f"finds cyclonedds {found}; valid: {_KNOWN}x")


@contextlib.contextmanager
def without_structure(topic: Any) -> Iterator[None]:
    """Hide the structure of a topic's type from endpoints that are made inside this context.

    Args:
        topic: Topic of Cyclone DDS.
    """
    shown = _functions(topic)
    kept = shown.value
    hidden = _Functions.from_buffer_copy(ctypes.string_at(kept or 0, ctypes.sizeof(_Functions)))
    # A copy, since the library's own table is shared by all types of its kind.
    for function in _OF_STRUCTURE:
        hidden[function] = None
    shown.value = ctypes.addressof(hidden)
    try:
        yield
    finally:
        shown.value = kept


def _functions(topic: Any) -> ctypes.c_void_p:
    """Return the place in memory where the topic's type keeps the address of its functions."""
    from cyclonedds.internal import load_cyclonedds

    # `ops` is the first member of the type, so the type's address is where it is kept.
    found = ctypes.c_void_p()
    library = load_cyclonedds()
    if library.dds_get_entity_sertype(ctypes.c_int32(topic._ref), ctypes.byref(found)) < 0:
        raise RuntimeError(f"topic {topic.name} has no type")
    return ctypes.c_void_p.from_address(found.value or 0)
