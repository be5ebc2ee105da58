"""Layouts that are not ours, whatever file they came from: categories in the source's own words.

The world frame is east, north, up in metres, quaternions are `wxyz`, box to world, the floor is at
z = 0. Every reader ends here, and all further steps (mapping, walls, flight volume) start here, so
that a new source only needs a reader.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from aeroscene.files.bounds import MOST_OBJECTS
from aeroscene.files.visible import visible
from aeroscene.scene import Quaternion, SceneError, Vector3

Point2 = tuple[float, float]
_MOST_ROOMS = 500
LayoutDomain = Literal["indoor", "outdoor"]


class LayoutError(SceneError):
    """A layout file that breaks a rule; one line names scene, object and field."""


def _make_visible(named: object, field_name: str) -> None:
    """Escape characters in a name that a terminal would obey; called while the object is built."""
    # The dataclasses are frozen, hence the detour.
    object.__setattr__(named, field_name, visible(getattr(named, field_name)))


@dataclass(frozen=True, slots=True, kw_only=True)
class LayoutObject:
    """One box of a layout."""

    category: str
    """Category in the source's words."""
    p: Vector3
    """Centre, ENU, m."""
    q: Quaternion
    """Unit quaternion wxyz, box to world."""
    s: Vector3
    """Full extents along the box's axes, m."""
    parent: int | None = None
    """Index of the object that this one stands on or in."""
    super_category: str = ""
    """The source's wider category, if it has one."""
    name: str = ""
    """Name of this very object in the source."""

    def __post_init__(self) -> None:
        """Escape characters in its names that a terminal would obey."""
        for name in ("category", "super_category", "name"):
            _make_visible(self, name)


@dataclass(frozen=True, slots=True, kw_only=True)
class LayoutRoom:
    """A room's outline, counter-clockwise, not closed, m."""

    name: str
    polygon: tuple[Point2, ...]

    def __post_init__(self) -> None:
        """Escape characters in its name that a terminal would obey."""
        _make_visible(self, "name")


@dataclass(frozen=True, slots=True, kw_only=True)
class NeutralLayout:
    """Boxes on a floor: the contents that all sources share."""

    scene_id: str
    source: str
    """Origin of the layout, in the source's words."""
    domain: LayoutDomain
    floor: tuple[Point2, ...]
    """Outline, counter-clockwise, not closed, m; empty if the source has no floor."""
    objects: tuple[LayoutObject, ...]
    rooms: tuple[LayoutRoom, ...] = ()
    doors: tuple[Point2, ...] = ()
    """Points of doors on the borders of rooms; empty if the source does not state any."""
    front: Literal["x", "y"] = "x"
    """Body axis that points to the front of an object."""
    attributes: Mapping[str, Any] = field(default_factory=dict, hash=False)
    """Further content of the source, unchecked."""
    invalid: tuple[str, ...] = ()
    """Objects that were left out because they broke a rule, one line each."""

    def __post_init__(self) -> None:
        """Refuse a layout that is beyond the bounds of a scene.

        Raises:
            LayoutError: If it has too many objects or rooms.
        """
        _make_visible(self, "scene_id")
        for name, most in (("objects", MOST_OBJECTS), ("rooms", _MOST_ROOMS)):
            if (count := len(getattr(self, name))) > most:
                raise LayoutError(f"{name} are {count}; valid: at most {most}")
