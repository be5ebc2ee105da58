"""OpenStreetMap's elements as its files hold them: nodes, ways of nodes, relations of ways.

Files come from anywhere, so all counts are bounded while the elements are read, before they fill
the memory.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from aeroscene.maps.bounds import Bounds
from aeroscene.maps.document import MapError
from aeroscene.scene.errors import shown

MOST_NODES = 1_000_000
MOST_REFERENCES = 3_000_000
"""Most references of all ways and relations together."""
MOST_OF_ONE = 20_000
"""Most references of one way or relation; OpenStreetMap itself allows 2,000 and 32,000."""
MOST_TAGS = 2_000_000
_MOST_TEXT = 1_000
"""Longest key or value of a tag; OpenStreetMap itself allows 255 characters."""

Tags = dict[str, str]
Member = tuple[str, int, str]
"""Type, number and role of a relation's member."""


@dataclass(slots=True)
class Way:
    """A line through nodes; closed if it ends at its first node."""

    nodes: list[int] = field(default_factory=list)
    tags: Tags = field(default_factory=dict)


@dataclass(slots=True)
class Relation:
    """Ways that belong together, such as the rings of an area with courtyards."""

    members: list[Member] = field(default_factory=list)
    tags: Tags = field(default_factory=dict)


@dataclass(slots=True)
class OsmData:
    """All elements of a file, checked while they are added."""

    nodes: dict[int, tuple[float, float]] = field(default_factory=dict)
    """Longitude and latitude, degrees."""
    node_tags: dict[int, Tags] = field(default_factory=dict)
    ways: dict[int, Way] = field(default_factory=dict)
    relations: dict[int, Relation] = field(default_factory=dict)
    bounds: Bounds | None = None
    n_references: int = 0
    n_tags: int = 0

    def add_node(self, number: int, longitude: float, latitude: float) -> None:
        """Add a node to the file's elements.

        Args:
            number: Id of the node.
            longitude: Degrees.
            latitude: Degrees.

        Raises:
            MapError: If it lies off the globe, or there are too many.
        """
        require_place(longitude, latitude, f"node {number}")
        if len(self.nodes) >= MOST_NODES:
            raise MapError(f"it has more than {MOST_NODES} nodes; valid: at most that, cut it out")
        self.nodes[number] = (longitude, latitude)

    def add_reference(self, owner: Way | Relation, member: int | Member, where: str) -> None:
        """Add a node to a way, or a member to a relation.

        Args:
            owner: Way or relation; changed.
            member: Id of a node for a way, a member for a relation.
            where: Name of the owner in errors.

        Raises:
            MapError: If it, or the whole file, has too many references.
        """
        self.n_references += 1
        target = owner.nodes if isinstance(owner, Way) else owner.members
        if len(target) >= MOST_OF_ONE or self.n_references > MOST_REFERENCES:
            most = MOST_OF_ONE if len(target) >= MOST_OF_ONE else MOST_REFERENCES
            raise MapError(f"{where} has more than {most} references; valid: at most that")
        target.append(member)  # pyrefly: ignore[bad-argument-type] - the caller pairs them

    def add_tag(self, tags: Tags, key: str, value: str, where: str) -> None:
        """Add a tag.

        Args:
            tags: Tags of the element; changed.
            key: Key.
            value: Value.
            where: Name of the element in errors.

        Raises:
            MapError: If it is too long, or there are too many tags.
        """
        self.n_tags += 1
        if self.n_tags > MOST_TAGS or max(len(key), len(value)) > _MOST_TEXT:
            raise MapError(
                f"{where} has tag {shown(key)}; valid: at most {_MOST_TEXT} characters, and "
                f"{MOST_TAGS} tags in all"
            )
        tags[key] = value


def require_place(longitude: float, latitude: float, where: str) -> None:
    """Refuse coordinates that lie off the globe.

    Raises:
        MapError: If longitude or latitude is out of range; it names the field.
    """
    if not (math.isfinite(longitude) and abs(longitude) <= 180):
        raise MapError(f"{where}: lon is {longitude}; valid: degrees from -180 to 180")
    if not (math.isfinite(latitude) and abs(latitude) <= 90):
        raise MapError(f"{where}: lat is {latitude}; valid: degrees from -90 to 90")
