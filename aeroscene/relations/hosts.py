"""Possible hosts of an object, ranked by facts that are known before any place is.

A host is the object that another one relates to, such as the table of a chair. Its rank is its
index in the list of possible hosts, 0 for the likeliest one. The list follows from categories,
parents and the order of drawing alone. A model that has not drawn any place yet therefore reads the
same host from a rank as the parser that gave it. A list has at most 24 hosts (`MAX_HOSTS`), and an
object whose host would come later gets another relation.
"""

from __future__ import annotations

from collections import defaultdict

from aeroscene.relations.relation import MAX_HOSTS, Kind
from aeroscene.scene import OrientedBox, SceneObject
from aeroscene.scene.catalogue import BRIDGES, CATALOGUE, LEVELS, ROADS, SIGNALS, STAIRS, TABLETOPS
from aeroscene.solids.shapes.structures import RAIL_M

# Coarse objects, then stairs, then all others.
N_TURNS = 3
_INSIDE = frozenset({Kind.EDGE, Kind.CENTRE, Kind.ON, Kind.SCATTER})


def is_furniture(category_id: int) -> bool:
    """True if objects on this category lie on its top.

    Other objects lie within their bearer: a ground, a room or a shell.
    """
    return CATALOGUE[category_id].level == "fine"


def turn_of(category_id: int) -> int:
    """Return the turn in which an object is drawn, 0 to 2.

    Coarse objects come first. Stairs come second, because they lead up to a coarse object, their
    host. Furniture and all other fine objects come last: an object that was drawn first keeps its
    place when a program is decoded, so furniture makes room for stairs.
    """
    category = CATALOGUE[category_id]
    if category.name in STAIRS:
        return 1
    return 0 if category.level == "coarse" else N_TURNS - 1


def level_m(category: str, box: OrientedBox) -> float:
    """Return the height of the level on which people walk.

    It is the top of an object; on a bridge it is the deck between the rails.
    """
    return box.p[2] + box.s[2] / 2 - (RAIL_M if category in BRIDGES else 0.0)


class Standing:
    """Objects that are drawn so far, in order."""

    def __init__(self, coarse: tuple[SceneObject, ...] = ()) -> None:
        """Begin with objects that need no relation."""
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
        """Add an object.

        Args:
            object_id: Its id.
            category_id: Number of its category.
            parent_id: Id of its bearer; None for the ground.
            seat_of: Id of the table at which a chair stands.
        """
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
        """Return the category of an object; empty for the ground."""
        return self._category.get(object_id, "")

    def bearer(self, object_id: int) -> int | None:
        """Return the id of an object's bearer; None for the ground."""
        return self._parent[object_id]

    def possible_hosts(
        self, kind: Kind, category_id: int, parent_id: int | None
    ) -> list[int | None]:
        """Return the possible hosts of an object in a relation, the likeliest first.

        Objects inside of something have their parent as host. At tables, beside, over and facing,
        hosts are the objects with the same parent, the last one first. A plate, or any other object
        beside something on a table, has the chairs of that table before these, the first one first.
        Some categories have other hosts: a traffic light the roads, stairs the levels. A vehicle in
        a lane has the road that bears it, then the other roads in the order of drawing.

        Args:
            kind: Kind of the relation.
            category_id: Number of the object's category.
            parent_id: Id of its bearer; None for the ground.

        Returns:
            At most `MAX_HOSTS` ids; None stands for the ground.
        """
        if kind in _INSIDE:
            return [parent_id]
        # The object that was drawn last has rank 0.
        beside: list[int | None] = list(reversed(self._children[parent_id]))
        if kind == Kind.LANE:
            # `sorted` is stable: the road that bears the vehicle first, then the others in order.
            return sorted(self._roads, key=lambda road: road != parent_id)[:MAX_HOSTS]
        if kind == Kind.SEAT:
            return [host for host in beside if self.category(host) in TABLETOPS][:MAX_HOSTS]
        if CATALOGUE[category_id].name in SIGNALS:
            return self._roads[:MAX_HOSTS]
        if CATALOGUE[category_id].name in STAIRS:
            return self._levels_from(parent_id)[:MAX_HOSTS]
        # A plate's chairs come first: they were drawn for this table.
        seats = self._seats[parent_id] if parent_id is not None and kind == Kind.SIDE else []
        return [*seats, *beside][:MAX_HOSTS]

    def _levels_from(self, parent_id: int | None) -> list[int | None]:
        """Return the levels: those on the same parent, those on its bearer, then all others."""

        def far(level: int | None) -> int:
            above = self._parent[level]
            return 0 if above == parent_id else 1 if above == self._parent.get(parent_id) else 2

        last_first = list(reversed(self._levels))
        last_first.sort(key=far)
        return last_first
