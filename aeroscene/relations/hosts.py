"""What an object may refer to: what stands already, ranked by what is known before any place is.

The ranks follow from categories, parents and the order of drawing alone, so that a model that has
drawn no place yet reads the same host from a rank as the parser that gave it.
"""

from __future__ import annotations

from collections import defaultdict

from aeroscene.relations.relation import MAX_HOSTS, Kind
from aeroscene.scene import OrientedBox, SceneObject
from aeroscene.scene.catalogue import CATALOGUE
from aeroscene.solids.shapes.structures import RAIL_M

SEATS = frozenset({"chair"})
"""What is drawn up to a table: sofas come before their coffee table."""
SEATED_AT = frozenset({"table", "desk", "counter", "coffee_table"})
VEHICLES = frozenset({"car", "van", "truck", "bus"})
AT_ROADS = frozenset({"traffic_light"})
"""What stands beside a road, whatever it stands on."""
AT_LEVELS = frozenset({"stairs"})
"""What leads up to a level beside it, whatever it stands on."""
LEVELS = frozenset({"terrain", "floor", "deck", "bridge", "roof", "container"})
"""What stairs lead up to."""
ROUND = frozenset(
    {"tree", "bush", "plant", "planter", "lamp", "bin", "barrel", "crate", "box", "plate", "cup"}
    | {"water_tank", "chimney", "antenna"}
)
"""What has no front."""
N_TURNS = 3
_ROAD = "road"
_INSIDE = frozenset({Kind.EDGE, Kind.CENTRE, Kind.ON, Kind.SCATTER})


def is_furniture(category_id: int) -> bool:
    """Whether what it bears lies on a top, and not within a ground, a room or a shell."""
    return CATALOGUE[category_id].level == "fine"


def turn_of(category_id: int) -> int:
    """When something is drawn: coarse things first, then what leads up to them, then the rest."""
    category = CATALOGUE[category_id]
    if category.name in AT_LEVELS:
        return 1
    return 0 if category.level == "coarse" else N_TURNS - 1


def level_m(category: str, box: OrientedBox) -> float:
    """Height of what one walks on, on something: its top, of a bridge its deck between rails."""
    return box.p[2] + box.s[2] / 2 - (RAIL_M if category == "bridge" else 0.0)


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
        category = CATALOGUE[category_id].name
        self._category[object_id] = category
        self._parent[object_id] = parent_id
        self._children[parent_id].append(object_id)
        if seat_of is not None:
            self._seats[seat_of].append(object_id)
        if category == _ROAD:
            self._roads.append(object_id)
        if category in LEVELS:
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
            return [host for host in beside if self._is_seated_at(host)][:MAX_HOSTS]
        if CATALOGUE[category_id].name in AT_ROADS:
            return self._roads[:MAX_HOSTS]
        if CATALOGUE[category_id].name in AT_LEVELS:
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

    def _is_seated_at(self, object_id: int | None) -> bool:
        return self.category(object_id) in SEATED_AT
