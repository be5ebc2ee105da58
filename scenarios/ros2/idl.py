"""Types of ROS 2 for Cyclone DDS, made of the definitions that rosbags has.

Cyclone checks what it receives against them. What it sends and what we take of it are bytes of CDR.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

Definitions = Mapping[str, Any]
"""Definition of each type by its name, as `Typestore.fielddefs`: constants, and fields."""
_CALLER = {"client": "uint64", "number": "int64"}
"""What rmw_cyclonedds_cpp has in front of a request and of a reply."""


class IdlTypes:
    """Makes the types, each once."""

    def __init__(self, definitions: Definitions) -> None:
        self._definitions = definitions
        self._made: dict[str, type] = {}

    def message(self, name: str) -> type:
        """Type of messages such as `sensor_msgs/msg/Imu`, whose samples are bytes."""
        return _raw(self._struct(name))

    def half(self, service: str, half: str) -> type:
        """Type of requests to a service such as `std_srvs/srv/Trigger`, or of its replies."""
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
        of, length = value
        if what == Nodetype.ARRAY:
            return types.array[self._type(*of), length]
        return types.sequence[self._type(*of)]


def sample(kind: type, data: bytes) -> Any:
    """A sample of a raw type by its bytes."""
    made: Any = object.__new__(kind)
    made.cdr = bytes(data)
    return made


def _make(name: str, fields: Mapping[str, Any]) -> type:
    from cyclonedds.idl import make_idl_struct

    package, folder, last = name.split("/")
    return make_idl_struct(last, f"{package}.{folder}.dds_.{last}_", dict(fields))


def _raw(kind: Any) -> type:
    """The type with samples that pass as they are."""
    kind.serialize = lambda each, **_: each.cdr
    kind.deserialize = classmethod(sample)
    return kind
