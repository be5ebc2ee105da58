"""What an object may refer to: what stands already, ranked by what is known before any place is.

The ranks follow from categories, parents and the order of drawing alone, so that a model that has
drawn no place yet reads the same host from a rank as the parser that gave it.
"""

from __future__ import annotations

from collections import defaultdict

from aeroscene.relations.relation import MAX_HOSTS, Kind
from aeroscene.scene import OrientedBox, SceneObject
from aeroscene.scene.catalogue import BRIDGES, CATALOGUE, LEVELS, ROADS, SIGNALS, STAIRS, TABLETOPS
from aeroscene.solids.shapes.structures import RAIL_M

N_TURNS = 3
_INSIDE = frozenset({Kind.EDGE, Kind.CENTRE, Kind.ON, Kind.SCATTER})


def is_furniture(category_id: int) -> bool:
    """Whether what it bears lies on a top, and not within a ground, a room or a shell."""
    return CATALOGUE[category_id].level == "fine"


def turn_of(category_id: int) -> int:
    """When something is drawn: coarse things first, then what leads up to them, then the rest."""
    category = CATALOGUE[category_id]
    if category.name in STAIRS:
        return 1
    return 0 if category.level == "coarse" else N_TURNS - 1


def level_m(category: str, box: OrientedBox) -> float:
    """Height of what one walks on, on something: its top, of a bridge its deck between rails."""
    return box.p[2] + box.s[2] / 2 - (RAIL_M if category in BRIDGES else 0.0)


class Standing:
    """What is drawn so far, in order."""

    def __init__(self, coarse: tuple[SceneObject, ...] = ()) -> None:
        """Begin with what needs no relation."""
        self._category: dict[int | None, str] = {}
        self._children: defaultdict[int | None, list[int]] = defaultdict(list)
        self._seats: defaultdict[int, list[int]] = defaultdict(list)
        self._roads: list[int | None] = []
        self._levels: list[int | None] = []
        self._parent: dict[int | None, int | None] = {None: None}
        for obj in coarse:
            self.add(obj.id, obj.category_id, obj.parent_id)

    def add(
        self, object_id: int, category_id: int, parent_id: int | None, seat_of: int | None = None
    ) -> None:
        """Let an object stand; a chair says at which table."""
        category = CATALOGUE[category_id]
        self._category[object_id] = category.name
        self._parent[object_id] = parent_id
        self._children[parent_id].append(object_id)
        if seat_of is not None:
            self._seats[seat_of].append(object_id)
        if category.name in ROADS:
            self._roads.append(object_id)
        if category.name in LEVELS:
            self._levels.append(object_id)

    def category(self, object_id: int | None) -> str:
        """The category of something; nothing for the bare world."""
        return self._category.get(object_id, "")

    def bearer(self, object_id: int) -> int | None:
        """What bears an object."""
        return self._parent[object_id]

    def possible_hosts(
        self, kind: Kind, category_id: int, parent_id: int | None
    ) -> list[int | None]:
        """What an object may have such a relation to, at most `MAX_HOSTS`, the likeliest first.

        Inside it is the parent. At tables, beside, over and facing it is what has the same parent,
        the last one first, and before it what the category is for: the road of a traffic light, the
        chair of a plate, the level of stairs.
        """
        if kind in _INSIDE:
            return [parent_id]
        beside: list[int | None] = list(reversed(self._children[parent_id]))
        if kind == Kind.LANE:
            return sorted(self._roads, key=lambda road: road != parent_id)[:MAX_HOSTS]
        if kind == Kind.SEAT:
            return [host for host in beside if self.category(host) in TABLETOPS][:MAX_HOSTS]
        if CATALOGUE[category_id].name in SIGNALS:
            return self._roads[:MAX_HOSTS]
        if CATALOGUE[category_id].name in STAIRS:
            return self._levels_from(parent_id)[:MAX_HOSTS]
        seats = self._seats[parent_id] if parent_id is not None and kind == Kind.SIDE else []
        return [*seats, *beside][:MAX_HOSTS]

    def _levels_from(self, parent_id: int | None) -> list[int | None]:
        """Levels: those on the same parent, those on what bears it, then all others."""

        def far(level: int | None) -> int:
            above = self._parent[level]
            return 0 if above == parent_id else 1 if above == self._parent.get(parent_id) else 2

        last_first = list(reversed(self._levels))
        last_first.sort(key=far)
        return last_first
