"""Types of ROS 2 for Cyclone DDS, made from the definitions that rosbags has.

Cyclone DDS needs a Python class for each type. Classes are made from rosbags' definitions, so that
no type is written down twice. Cyclone checks received samples against them, but both directions
pass bytes of CDR, which rosbags encodes and decodes.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

Definitions = Mapping[str, Any]
"""Definition of each type by its name, as `Typestore.fielddefs`: constants, and fields."""
_CALLER = {"client": "uint64", "number": "int64"}
"""Fields that rmw_cyclonedds_cpp puts before a request and before a reply."""


class IdlTypes:
    """Makes the types of Cyclone DDS, each once."""

    def __init__(self, definitions: Definitions) -> None:
        self._definitions = definitions
        self._made: dict[str, type] = {}

    def message(self, name: str) -> type:
        """Return the type of a message, whose samples are bytes.

        Args:
            name: Full name, such as `sensor_msgs/msg/Imu`.
        """
        return _raw(self._struct(name))

    def half(self, service: str, half: str) -> type:
        """Return the type of the requests to a service, or of its replies.

        Args:
            service: Full name, such as `std_srvs/srv/Trigger`.
            half: "Request" or "Response".
        """
        from cyclonedds.idl import types

        package, _, name = service.split("/")
        caller = {field: getattr(types, kind) for field, kind in _CALLER.items()}
        fields = self._fields(f"{package}/msg/{name}_{half}")
        return _raw(_make(f"{service}_{half}", {**caller, **fields}))

    def _struct(self, name: str) -> type:
        if name not in self._made:
            self._made[name] = _make(name, self._fields(name))
        return self._made[name]

    def _fields(self, name: str) -> dict[str, Any]:
        _, fields = self._definitions[name]
        return {field: self._type(*kind) for field, kind in fields}

    def _type(self, what: Any, value: Any) -> Any:
        from cyclonedds.idl import types
        from rosbags.interfaces import Nodetype

        if what == Nodetype.NAME:
            return self._struct(value)
        if what == Nodetype.BASE:
            base, _ = value
            return {"string": str, "bool": bool}.get(base) or getattr(types, base)
        # An array has a fixed length, a sequence any (the length is then a bound).
        of, length = value
        if what == Nodetype.ARRAY:
            return types.array[self._type(*of), length]
        return types.sequence[self._type(*of)]


def sample(kind: type, data: bytes) -> Any:
    """Return a sample of a raw type with the given bytes.

    Args:
        kind: Type that `IdlTypes` has made.
        data: Sample in CDR, with the header of its encoding.
    """
    # Without `__init__`, which would ask for every field.
    made: Any = object.__new__(kind)
    made.cdr = bytes(data)
    return made


def _make(name: str, fields: Mapping[str, Any]) -> type:
    from cyclonedds.idl import make_idl_struct

    # ROS 2's name of a type in DDS has "dds_" before it and "_" behind it.
    package, folder, last = name.split("/")
    return make_idl_struct(last, f"{package}.{folder}.dds_.{last}_", dict(fields))


def _raw(kind: Any) -> type:
    """Return the type with its two functions replaced, so that samples pass as bytes."""
    kind.serialize = lambda each, **_: each.cdr
    kind.deserialize = classmethod(sample)
    return kind
