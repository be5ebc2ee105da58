"""A scene under construction: its objects so far, and the tokens that they stand for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from aeroscene.feasibility.doors import air_of
from aeroscene.feasibility.place_search import Blocks
from aeroscene.learning.program.companions import host_key
from aeroscene.learning.program.decoding.draft.neighbours import Neighbours
from aeroscene.learning.program.decoding.draft.supports import is_on_any
from aeroscene.learning.program.decoding.draft.trees import TreeReader
from aeroscene.learning.program.kinds import CATEGORY_IDS, SiteKind
from aeroscene.learning.program.measures import BARE_SITE, site_rectangle
from aeroscene.learning.program.program import Program
from aeroscene.relations.hosts import Standing
from aeroscene.relations.plane import Rectangle, footprint, hull
from aeroscene.relations.relation import Kind
from aeroscene.scene import AttributeValue, ObjectDomain, OrientedBox, Scene, SceneObject
from aeroscene.scene.catalogue import WALLS
from aeroscene.scene.rooms import room_of, strayed_to, tile_groups


@dataclass(frozen=True, eq=False)
class Given:
    """Objects that stand as they are, whatever a program says of them."""

    scene: Scene
    object_ids: Mapping[int, tuple[int, ...]]
    """Ids of the objects of each token; some objects may have no token."""
    first_id: int = 0
    """Least id of new objects; ids of removed objects are not used again."""


@dataclass(eq=False)
class Draft:
    """The objects so far; the id of each is its place in the order."""

    program: Program
    objects: list[SceneObject] = field(default_factory=list)
    standing: Standing = field(default_factory=Standing)
    neighbours: Neighbours = field(default_factory=Neighbours)

    def __post_init__(self) -> None:
        self.children = self.program.children()
        self.trees = TreeReader(self.program, self.children)
        self.made: list[list[int]] = [[] for _ in self.program.kinds]
        """Objects of each token."""
        self._place_of: list[tuple[int | None, int]] = []
        """Token of each object, and the object's number among those of the token."""
        self.pitches_m: dict[int, tuple[float, float]] = {}
        """Pitches between rows and between columns of each token that stands for an array."""
        heads = ((self.program.kinds[i], self.program.channels[i]) for i in self.children[0])
        sites = (site_rectangle(kind, c) for kind, c in heads if isinstance(kind, SiteKind))
        # A program without covers has no site; a bare square stands for it.
        self._site = next(sites, BARE_SITE)

    def begin_with(self, given: Given) -> None:
        """Add given objects, in the order of their scene."""
        number_of: dict[int | None, int | None] = {None: None}
        for number, obj in enumerate(given.scene.objects):
            number_of[obj.id] = number
            parent = number_of[obj.parent_id]
            self.objects.append(replace(obj, id=number, parent_id=parent))
            self.neighbours.add(obj.bbox, obj.category, parent)
            self._place_of.append((None, 0))
            # The air before given doors stays free, too.
            air = air_of(obj.bbox, obj.attributes) if obj.category in WALLS else None
            if air is not None:
                self.neighbours.add_air(air)
        for place in range(len(self.program)):
            for object_id in given.object_ids.get(place, ()):
                number = number_of[object_id]
                assert number is not None
                self._place_of[number] = place, len(self.made[place])
                self.made[place].append(number)
                bearer, category_id = self._bearer(place), self.objects[number].category_id
                table = self._table(place, category_id, bearer)
                self.standing.add(number, category_id, bearer, table)

    def _bearer(self, place: int) -> int | None:
        """Return the bearer of a token's objects, from the nearest token above with objects."""
        while place:
            member, place = int(self.program.member[place]), int(self.program.parent[place])
            if self.made[place]:
                # The drawn number may exceed the number of objects: the last one counts.
                return self.made[place][min(member, len(self.made[place]) - 1)]
        return None

    def _table(self, place: int, category_id: int, bearer: int | None) -> int | None:
        """Return the table of given chairs, or None."""
        kind = self.program.kinds[place]
        if kind.relation != Kind.SEAT.name:
            return None
        hosts = self.standing.possible_hosts(Kind.SEAT, category_id, bearer)
        rank = int(self.program.host[place])
        return hosts[rank] if rank < len(hosts) else None

    def below(self, bearer: int | None, node: str) -> list[int]:
        """Return the tokens of a node on an object.

        The last object of a token also bears the tokens of objects that were not made.

        Args:
            bearer: Id of the object; None for the ground.
            node: Node of the tokens, such as `unit`.
        """
        place, number = (0, 0) if bearer is None else self._place_of[bearer]
        if place is None:
            return []
        # A draw may name a member that was not made: its objects go to the last one.
        is_last = place == 0 or number == len(self.made[place]) - 1
        found = (i for i in self.children[place] if self.program.kinds[i].node == node)
        members = ((i, int(self.program.member[i])) for i in found)
        return [i for i, member in members if member == number or (is_last and member > number)]

    def box(self, object_id: int | None) -> OrientedBox | None:
        """Return the box of an object; None for the ground."""
        return None if object_id is None else self.objects[object_id].bbox

    def base_m(self, object_id: int | None) -> float:
        """Return the height of an object's underside; 0 for the ground."""
        box = self.box(object_id)
        return 0.0 if box is None else box.p[2] - box.s[2] / 2

    def host_key(self, object_id: int | None) -> str:
        """Return the key of an object as a host, see `aeroscene.learning.program.companions`."""
        if object_id is None:
            return host_key("", "")
        place = self._place_of[object_id][0]
        relation = "" if place is None else self.program.kinds[place].relation
        return host_key(self.objects[object_id].category, relation)

    def group_of(self, object_id: int) -> list[int]:
        """Return the objects of an object's token, itself among them."""
        place = self._place_of[object_id][0]
        return [object_id] if place is None else list(self.made[place])

    def pitch_m(self, object_id: int) -> tuple[float, float] | None:
        """Return the pitch of an object's array; None if it was not drawn as one."""
        place = self._place_of[object_id][0]
        return None if place is None else self.pitches_m.get(place)

    def outline(self, object_id: int | None) -> Rectangle:
        """Return an object from above; the site for None."""
        return self._site if object_id is None else footprint(self.objects[object_id].bbox)

    def tiles(self, room: int) -> list[Rectangle]:
        """Return all tiles of the room to which an object belongs, from above."""
        return [footprint(self.objects[number].bbox) for number in self._tiles(room)]

    def extent(self, bearer: int | None) -> Rectangle | None:
        """Return the outline that a bearer's objects keep to.

        For a tile of a room it is the hull of all tiles of that room. The ground has no limit:
        None.
        """
        if bearer is None:
            return None
        tiles = self.tiles(bearer)
        return tiles[0] if len(tiles) == 1 else hull(tiles)

    def is_borne(self, bearer: int | None, boxes: Sequence[OrientedBox]) -> bool:
        """True if the middles of boxes are on tiles of the bearer's room.

        A room of one tile needs no test, because its outline limits the shift already.
        """
        tiles = [] if bearer is None else self.tiles(bearer)
        return len(tiles) < 2 or all(is_on_any(box, tiles) for box in boxes)

    def _tiles(self, room: int) -> list[int]:
        own = room_of(self.objects[room])
        if own is None:
            return [room]
        return [number for number, obj in enumerate(self.objects) if room_of(obj) == own]

    def taken(
        self, bearer: int | None, without: Sequence[int] = (), *, has_air: bool = True
    ) -> Blocks:
        """Return the obstacles of an object on a bearer.

        Args:
            bearer: Id of the bearer, which is no obstacle, and neither are other tiles of its room.
            without: Ids of further objects that are none, such as those that move along.
            has_air: False leaves out the air before doors.
        """
        tiles = [] if bearer is None else self._tiles(bearer)
        return self.neighbours.taken(bearer, [*without, *tiles], has_air=has_air)

    def let_tiles_bear(self) -> None:
        """Give each object in another tile of its room the tile that it is in as parent."""
        objects = self.objects
        parents, boxes = [obj.parent_id for obj in objects], [obj.bbox for obj in objects]
        for row, tile in strayed_to(tile_groups(objects), parents, boxes).items():
            objects[row] = replace(objects[row], parent_id=tile)

    def add(
        self,
        place: int | None,
        category: str,
        domain: str,
        attributes: dict[str, AttributeValue],
        box: OrientedBox,
        *,
        parent: int | None,
        bearer: int | None,
        table: int | None = None,
    ) -> None:
        """Append an object.

        Args:
            place: Place of its token, whose looks it gets; None for none.
            category: Its category.
            domain: Its domain.
            attributes: Its attributes beside its looks.
            box: Its box.
            parent: Id of its parent in the scene.
            bearer: Id of the object that it stands on.
            table: Id of the table at which it is a seat.
        """
        number = len(self.objects)
        looks: dict[str, AttributeValue] = {}
        if place is not None:
            drawn = self.program.looks[place] if self.program.looks else ()
            # A group with one drawn look repeats it for all members.
            looks = drawn[min(len(self.made[place]), len(drawn) - 1)] if drawn else {}
            self.made[place].append(number)
        self._place_of.append((place, 0 if place is None else len(self.made[place]) - 1))
        own: ObjectDomain = "indoor" if domain == "indoor" else "outdoor"
        category_id = CATEGORY_IDS[category]
        self.objects.append(
            SceneObject(
                id=number,
                scene_id="",
                parent_id=parent,
                category_id=category_id,
                bbox=box,
                domain=own,
                attributes=looks | attributes,
            )
        )
        self.neighbours.add(box, category, parent)
        self.standing.add(number, category_id, bearer, table)

    def move(self, object_id: int, box: OrientedBox) -> None:
        """Move an object to another box."""
        self.objects[object_id] = replace(self.objects[object_id], bbox=box)
        self.neighbours.move(object_id, box)
