"""Streams that entities of a recording are written to: the whole one, or one vehicle's part of it.

The first vehicle has the paths of `layout`, so that a recording of several vehicles is read like
one of a single vehicle. Another vehicle has its paths below its name: `world/vehicle_2/...` for
entities with a place in the world, `vehicle_2/...` for the others. Writers such as `StateLog` take
either kind of stream, and so need not know how many vehicles there are.
"""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

import rerun as rr

from scenarios.recording import layout


@runtime_checkable
class EntityStream(Protocol):
    """Stream that entities are written to, with the methods of `rerun.RecordingStream`."""

    def set_time(self, timeline: str, *, duration: Any) -> None:
        """Set the time of the entities that are logged next.

        Args:
            timeline: Name of the timeline, `layout.TIMELINE`.
            duration: Time since the start, as a timedelta.
        """
        ...

    def log(self, entity_path: Any, entity: Any, *extra: Any, static: bool = False) -> None:
        """Write an entity at the present time.

        Args:
            entity_path: Path, as `layout` names it.
            entity: rerun's archetype.
            extra: Further archetypes of the same entity.
            static: True for an entity that never changes.
        """
        ...

    def send_columns(self, entity_path: str, indexes: Any, columns: Any) -> None:
        """Write many rows of an entity at once.

        Args:
            entity_path: Path, as `layout` names it.
            indexes: Time columns.
            columns: Component columns with as many rows.
        """
        ...


class VehicleStream:
    """Part of a stream in which one vehicle after the first has its entities."""

    def __init__(self, stream: rr.RecordingStream, name: str) -> None:
        """Write to a stream below the name of a vehicle.

        Args:
            stream: The whole recording.
            name: Name of the vehicle, such as `vehicle_2`.
        """
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
