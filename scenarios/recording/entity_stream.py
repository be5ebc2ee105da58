"""Where entities of a recording go: to the stream itself, or to the part of one vehicle in it.

The first vehicle has the paths of `layout`, so that a recording of several is read like one of a
single vehicle. Those of another one stand below its name: `world/vehicle_2/...` for what has a
place in the world, `vehicle_2/...` for the rest.
"""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

import rerun as rr

from scenarios.recording import layout


@runtime_checkable
class EntityStream(Protocol):
    """What entities are written to; `rerun.RecordingStream` is one."""

    def set_time(self, timeline: str, *, duration: Any) -> None:
        """Set the time of what is logged next."""
        ...

    def log(self, entity_path: Any, entity: Any, *extra: Any, static: bool = False) -> None:
        """Write an entity."""
        ...

    def send_columns(self, entity_path: str, indexes: Any, columns: Any) -> None:
        """Write columns of an entity."""
        ...


class VehicleStream:
    """The part of a stream in which one vehicle after the first has its entities."""

    def __init__(self, stream: rr.RecordingStream, name: str) -> None:
        """Write to a stream, below the name of the vehicle, such as `vehicle_2`."""
        self._stream = stream
        self._name = name

    def set_time(self, timeline: str, *, duration: Any) -> None:
        """See `EntityStream`."""
        self._stream.set_time(timeline, duration=duration)

    def log(self, entity_path: str, entity: Any, *extra: Any, static: bool = False) -> None:
        """See `EntityStream`."""
        path = layout.of_vehicle(self._name, entity_path)
        self._stream.log(path, entity, *extra, static=static)

    def send_columns(self, entity_path: str, indexes: Any, columns: Any) -> None:
        """See `EntityStream`."""
        path = layout.of_vehicle(self._name, entity_path)
        self._stream.send_columns(path, indexes, columns)
