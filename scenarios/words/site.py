"""A scene as texts refer to it: places with a kind, looks, a footprint, a storey and a host.

The scene's objects are close to the things that people name, with exceptions: tiles of one room are
one room, and a terrain object is a mound or a ramp. A `Site` makes these places once, and answers
geometric questions about them. Answers are kept, because drawing one text asks thousands of them.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property

import numpy as np
import shapely
from jaxtyping import Float
from shapely.geometry.base import BaseGeometry

from aeroscene.scene import InteractionArea, Scene, SceneObject
from aeroscene.scene.catalogue import COVERS, DECKS, PADS, ROOFS, ROOMS, SHELLS, TABLETOPS, TERRAIN
from aeroscene.scene.footprint import footprint
from aeroscene.scene.rooms import room_of
from scenarios.words.goal import Description, Link
from scenarios.words.looks import colours_of, form_of, prevailing
from scenarios.words.vocabulary import COLOURED, TERRAIN_FORMS


class Truth(IntEnum):
    """Outcome of a condition. Outcomes are ordered, so that `min` joins several conditions."""

    NO = 0
    MAYBE = 1
    """Some readers would say so, and others not."""
    YES = 2


HOSTS = COVERS | ROOFS | ROOMS | DECKS | TABLETOPS | PADS | TERRAIN_FORMS
"""Kinds on which, or in which, other objects stand."""
_TRACE = 0.04
"""Share of the surface below which a colour is a mere trace, by which nobody names an object."""
_STOREY_M = 1.5
"""Rooms whose floors lie closer than this are on one storey."""
_ABOVE_M, _BELOW_M = 0.3, 0.15
"""Range of the underside of an object on a host: up to this far above the host's top, and up to
this far below the host's underside."""
_INSIDE_M = 0.3
"""Length by which an object may extend beyond the edge of its host."""
_SAMPLES = 5
"""Points of a footprint along each axis, by which directions are judged."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Place:
    """An object of the scene, or a room of several tiles."""

    id: int
    """Number among the places of the scene."""
    kind: str
    objects: tuple[SceneObject, ...]
    colour: str | None
    """Colour by which a reader would call it; None if none prevails or catches the eye."""
    colours: frozenset[str]
    """Adjectives of all colours that it shows, except for traces."""
    form: str | None
    ground: BaseGeometry
    """Footprint, ENU, m."""
    bottom_m: float
    top_m: float
    areas: tuple[InteractionArea, ...]
    """Landing areas that it carries, whatever their class."""

    @cached_property
    def object_ids(self) -> frozenset[int]:
        """Ids of the objects that it is made of."""
        return frozenset(obj.id for obj in self.objects)

    @cached_property
    def centre(self) -> Float[np.ndarray, " 2"]:
        """Middle of the footprint, ENU, m."""
        return np.array(self.ground.centroid.coords[0])

    @cached_property
    def points(self) -> Float[np.ndarray, "n 2"]:
        """Points all over the footprint, including its corners, ENU, m."""
        low_x, low_y, high_x, high_y = self.ground.bounds
        xs, ys = np.linspace(low_x, high_x, _SAMPLES), np.linspace(low_y, high_y, _SAMPLES)
        grid = np.array([(x, y) for x in xs for y in ys])
        inside = shapely.contains_xy(self.ground, grid)
        return np.concatenate([grid[inside], shapely.get_coordinates(self.ground)])


class Site:
    """All places of a scene, with distances, hosts, rooms and storeys.

    Attributes:
        places: All places, in the order of the objects.
    """

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self.places = _places(scene)
        self._of_object = {i: place for place in self.places for i in place.object_ids}
        self._grounds = np.array([place.ground for place in self.places], dtype=object)
        shapely.prepare(self._grounds)
        self._of_kind: dict[str, list[Place]] = {}
        for place in self.places:
            self._of_kind.setdefault(place.kind, []).append(place)
        self._possible: dict[int, list[tuple[Place, bool]]] = {}
        self._gaps_m: dict[int, Float[np.ndarray, " n"]] = {}
        self.hosts = [place for place in self.places if place.kind in HOSTS]
        self.heads: dict[int, list[Description]] = {}
        """Descriptions without relations that fit each place, kept by `goal_drawing`."""
        self.fits: dict[Description, Mapping[Place, Truth]] = {}
        """Results of `grounding.fits`."""
        self.holds: dict[Link, dict[int, Truth]] = {}
        """Outcomes of relations, by the number of the place, kept by `grounding`."""

    def of_kind(self, kind: str) -> Sequence[Place]:
        """Return the places of a kind, in the order of the objects."""
        return self._of_kind.get(kind, ())

    def gap_m(self, place: Place, mark: Place) -> float:
        """Return the distance between two footprints, 0 if they touch or overlap.

        Args:
            place: One place.
            mark: The other place, whose distances to all places are then kept.
        """
        if mark.id not in self._gaps_m:
            self._gaps_m[mark.id] = shapely.distance(self._grounds, mark.ground)
        return float(self._gaps_m[mark.id][place.id])

    def place_of(self, object_id: int | None) -> Place | None:
        """Return the place that an object is, or is a part of; None for the bare ground.

        Args:
            object_id: Id of the object; None for the ground.
        """
        return None if object_id is None else self._of_object.get(object_id)

    def whole_of(self, place: Place) -> Place | None:
        """Return the building that a roof or a room belongs to, None if it belongs to none."""
        for above in self._scene.ancestors(place.objects[0].id):
            if (found := self._of_object.get(above)) is not None and found.kind in SHELLS:
                return found
        return None

    @cached_property
    def room_by_id(self) -> Mapping[int, Place | None]:
        """Room of each place, by the number of the place; None outside of rooms."""
        rooms = [place for place in self.places if place.kind in ROOMS]
        found: dict[int, Place | None] = {}
        for place in self.places:
            above = (self._of_object.get(i) for i in self._scene.ancestors(place.objects[0].id))
            named = (each for each in above if each is not None and each.kind in ROOMS)
            found[place.id] = next(named, None)
        # Geometry comes after parents and wins: an object may be inside a room that is no parent.
        centres = np.array([place.centre for place in self.places])
        bottoms_m = np.array([place.bottom_m for place in self.places])
        for room in reversed(rooms):
            is_held = shapely.contains_xy(room.ground, centres)
            is_held &= bottoms_m >= room.bottom_m - _BELOW_M
            is_held &= bottoms_m < room.top_m - _ABOVE_M
            found |= {int(i): room for i in np.flatnonzero(is_held) if i != room.id}
        return found

    @cached_property
    def storey_by_id(self) -> Mapping[int, int]:
        """Storey of each room, by the number of the place; only buildings with several count."""
        rooms: dict[int | None, list[Place]] = {}
        for place in self.places:
            if place.kind in ROOMS:
                whole = self.whole_of(place)
                rooms.setdefault(None if whole is None else whole.id, []).append(place)
        found: dict[int, int] = {}
        for group in rooms.values():
            storeys = _storeys([place.bottom_m for place in group])
            if max(storeys) > 0:
                found |= {place.id: storey for place, storey in zip(group, storeys, strict=True)}
        return found

    def storey_of(self, place: Place) -> int | None:
        """Return the storey of a room or of a place in one.

        Args:
            place: Any place.

        Returns:
            0 for the lowest storey; None outside of rooms, or if the building has only one storey.
        """
        room = place if place.kind in ROOMS else self.room_by_id[place.id]
        return None if room is None else self.storey_by_id.get(room.id)

    def foot_of(self, place: Place) -> Place:
        """Return what an observer on the ground sees of a place: for a roof, its building."""
        whole = self.whole_of(place) if place.kind in ROOFS else None
        return place if whole is None else whole

    def stands_on(self, place: Place, host: Place) -> bool | None:
        """Return true if a place stands on a host or in it, None if that is debatable."""
        for each, is_sure in self.standing_on(host):
            if each is place:
                return is_sure or None
        return False

    def standing_on(self, host: Place) -> Sequence[tuple[Place, bool]]:
        """Return the places that stand on a host, each with true if that is beyond dispute."""
        if host.id not in self._possible:
            self._possible[host.id] = list(self._standing_on(host))
        return self._possible[host.id]

    def _standing_on(self, host: Place) -> Sequence[tuple[Place, bool]]:
        found: list[tuple[Place, bool]] = []
        if host.kind not in HOSTS:
            return found
        about = host.ground.buffer(_INSIDE_M)
        for number in np.flatnonzero(shapely.intersects(self._grounds, host.ground)):
            place = self.places[number]
            if place is host:
                continue
            # In a room, the underside must be below the ceiling: objects on its roof are not in it.
            most_m = host.top_m + (-_ABOVE_M if host.kind in ROOMS else _ABOVE_M)
            if not host.bottom_m - _BELOW_M <= place.bottom_m <= most_m:
                continue
            is_within = about.contains(place.ground)
            parent = self.place_of(place.objects[0].parent_id)
            is_others = parent is not None and parent is not host and parent.kind in HOSTS
            # A cup on a table in a room is in the room. But a bench on a square within a lawn is
            # not on the lawn.
            is_others = is_others and host.kind not in ROOMS
            found.append((place, is_within and not is_others))
        return found


@functools.lru_cache(maxsize=4)
def site_of(scene: Scene) -> Site:
    """Return the places of a scene; the last four scenes are kept for further texts."""
    return Site(scene)


def _places(scene: Scene) -> tuple[Place, ...]:
    groups: dict[object, list[SceneObject]] = {}
    for obj in scene.objects:
        # Tiles of one room share its name and its parent. Any other object is a group of its own.
        groups.setdefault(room_of(obj) or obj.id, []).append(obj)
    areas: dict[int | None, list[InteractionArea]] = {}
    for area in scene.landing_areas:
        areas.setdefault(area.object_id, []).append(area)
    return tuple(
        _place(number, objects, tuple(area for obj in objects for area in areas.get(obj.id, ())))
        for number, objects in enumerate(groups.values())
    )


def _place(
    number: int, objects: Sequence[SceneObject], areas: tuple[InteractionArea, ...]
) -> Place:
    first = objects[0]
    kind = first.category
    if kind in TERRAIN:
        kind = str(first.attributes.get("form", kind))
    # All tiles of a room look alike, so the first one stands for them.
    shares = colours_of(first)
    heights = np.concatenate([obj.bbox.corners()[:, 2] for obj in objects])
    return Place(
        id=number,
        kind=kind,
        objects=tuple(objects),
        colour=prevailing(shares) if kind in COLOURED else None,
        colours=frozenset(word for word, share in shares.items() if share >= _TRACE),
        form=form_of(first, kind),
        ground=shapely.union_all([footprint(obj) for obj in objects]),
        bottom_m=float(heights.min()),
        top_m=float(heights.max()),
        areas=areas,
    )


def _storeys(floors_m: Sequence[float]) -> list[int]:
    """Return the storey of each floor by its height, 0 for the lowest one."""
    order = np.argsort(floors_m, kind="stable")
    storeys, number = [0] * len(floors_m), 0
    for before, after in itertools.pairwise(order):
        # A larger step in height begins a new storey.
        number += floors_m[after] - floors_m[before] > _STOREY_M
        storeys[after] = number
    return storeys
