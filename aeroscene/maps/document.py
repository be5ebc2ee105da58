"""Maps, whatever file they came from: features with tags and a geometry."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field

from shapely.geometry.base import BaseGeometry

from aeroscene.files.visible import visible
from aeroscene.maps.bounds import Bounds
from aeroscene.scene import SceneError

Tags = Mapping[str, str]


class MapError(SceneError):
    """A map that breaks a rule; one line names file, feature and field."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Feature:
    """One feature of a map: a point, a line or an area, with its tags."""

    source_id: str
    """Its name in the map, such as `way/4711`."""
    tags: Tags
    """Keys and values as OpenStreetMap has them: `building`, `highway`, `natural`..."""
    geometry: BaseGeometry
    """Point, LineString, Polygon or MultiPolygon; degrees in a file, metres in a `PlaceMap`."""

    def __post_init__(self) -> None:
        """Escape characters in its name that a terminal would obey."""
        object.__setattr__(self, "source_id", visible(self.source_id))


@dataclass(frozen=True, slots=True, kw_only=True)
class RawMap:
    """Contents of a map file."""

    features: tuple[Feature, ...]
    """Geometries in degrees: longitude, latitude."""
    bounds: Bounds | None
    """Bounds that the file itself states."""
    dropped: Counter[str] = field(default_factory=Counter)
    """Number of features that could not be read, under the reason."""
