"""Decodes programs: covers, then what stands on them, storeys in buildings, and so on down.

It gives a scene for any program, so that a draw of a model needs no luck: see `growing`,
`settling` and `units` for what is done with what does not fit.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from aeroscene.feasibility.boxes import boxes_of
from aeroscene.feasibility.doors import air_of
from aeroscene.feasibility.roles import FITTINGS, GROUND, POSTS
from aeroscene.feasibility.seats import TABLES, turns_to_tables
from aeroscene.feasibility.traffic import turns_with_traffic
from aeroscene.learning.program.decoding.buildings import DecodedBuilding, build_building
from aeroscene.learning.program.decoding.extent import extent_of
from aeroscene.learning.program.decoding.growing import Grower
from aeroscene.learning.program.decoding.mending import AFLOAT, LAID, laid_for, mended
from aeroscene.learning.program.decoding.neighbours import (
    Neighbours,
    clashing,
    free_shift,
    moved,
    open_ways,
)
from aeroscene.learning.program.decoding.settling import settled
from aeroscene.learning.program.decoding.units import member_boxes, read_unit
from aeroscene.learning.program.kinds import CATEGORY_IDS, OPENINGS, Kind, Word, theme_of
from aeroscene.learning.program.measures import site_rectangle
from aeroscene.learning.program.nesting import cells
from aeroscene.learning.program.program import OPENING, Program
from aeroscene.partition import SitePartition, build_site, from_sequence
from aeroscene.partition.tree import VOID
from aeroscene.relations import Kind as RelationKind
from aeroscene.relations import Unit
from aeroscene.relations.hosts import AT_LEVELS, N_TURNS, Standing, turn_of
from aeroscene.relations.plane import Rectangle, footprint
from aeroscene.relations.relation import N_SIDES
from aeroscene.scene import AttributeValue, ObjectDomain, OrientedBox, Scene, SceneObject
from aeroscene.scene.box import quat_from_yaw
from aeroscene.scene.origin import ALTITUDE_M, LATITUDE_DEG, LONGITUDE_DEG

LEAST_COVER_M = 0.05
_STOREY_M = 1.2
"""Least height of an upper storey's floor above the first."""
_ON_M = 1e-6
_FIXED = GROUND | FITTINGS | AT_LEVELS | POSTS | {"roof"}
"""What lies where it was drawn, whatever stands there."""
_MOST_LEFT_OUT = 0.5
"""Largest share of a group that is left out for want of room."""
_SAME_M = 1e-3


@dataclass(frozen=True, eq=False, kw_only=True)
class DecodedProgram:
    """A scene, and which of its objects each token stands for."""

    scene: Scene
    object_ids: tuple[tuple[int, ...], ...]


def decode(program: Program, scene_id: str = "program", seed: int = 0) -> DecodedProgram:
    """The scene of a program, whatever its numbers; without interaction areas."""
    builder = _Builder(program)
    builder.build()
    low, high = extent_of(builder.objects, program.kinds[0].domain)
    objects = tuple(replace(obj, scene_id=scene_id) for obj in builder.objects)
    pad = next((obj for obj in objects if obj.attributes.get("is_start")), None)
    start = (0.0, 0.0, 0.0) if pad is None else pad.bbox.p
    top_m = 0.0 if pad is None else start[2] + pad.bbox.s[2] / 2
    start = np.clip((start[0], start[1], round(top_m, 4)), low, high).tolist()
    domain = program.kinds[0].domain
    scene = Scene(
        scene_id=scene_id,
        domain="indoor" if domain == "indoor" else "mixed" if domain == "mixed" else "outdoor",
        seed=seed,
        extent_min_enu_m=low,
        extent_max_enu_m=high,
        start_position_enu_m=(start[0], start[1], start[2]),
        start_yaw_rad=round(math.atan2(-start[1], -start[0]), 6),
        latitude_deg=LATITUDE_DEG,
        longitude_deg=LONGITUDE_DEG,
        altitude_m=ALTITUDE_M,
        objects=objects,
        theme=theme_of(program.kinds[0]),
    )
    return DecodedProgram(scene=scene, object_ids=tuple(map(tuple, builder.made)))


@dataclass(eq=False)
class _Builder:
    program: Program
    objects: list[SceneObject] = field(default_factory=list)
    standing: Standing = field(default_factory=Standing)
    neighbours: Neighbours = field(default_factory=Neighbours)

    def __post_init__(self) -> None:
        self.children = self.program.children()
        self.grower = Grower(self.program, self.children)
        self.made: list[list[int]] = [[] for _ in self.program.kinds]
        self.buildings: dict[int | None, DecodedBuilding] = {}
        """Those with storeys, by what they are in."""
        self.slabs: list[tuple[int, OrientedBox]] = []
        """Upper slabs that were drawn of the building at hand, each with its token."""
        self.place_of: list[tuple[int | None, int]] = []
        """The token of each object, and which of the token's objects it is."""
        heads = [i for i in self.children[0] if self.program.kinds[i].node == "site"]
        self.site = site_rectangle(self.program.channels[heads[0]] if heads else None)

    def build(self) -> None:
        """Everything, from the ground up: turn by turn, and object by object as it was read."""
        for place in self.children[0]:
            if self.program.kinds[place].node == "site":
                self._add_site(place)
        n_built = 0
        queue: list[int | None] = [None, *range(len(self.objects))]
        for turn in range(N_TURNS):
            for number, bearer in enumerate(queue):
                before = len(self.objects)
                if number >= n_built:
                    self._add_storeys(bearer)
                    n_built += 1
                for place in self._below(bearer, "unit"):
                    if not self.made[place] and self._turn_of(place) <= turn:
                        self._add_unit(place, bearer)
                self._lay_slabs(bearer)
                queue += range(before, len(self.objects))
        known = self.objects, boxes_of(self.objects), np.ones(len(self.objects), dtype=bool)
        for row, turn_rad in [*turns_to_tables(*known), *turns_with_traffic(*known)]:
            own = self.objects[row]
            quat = quat_from_yaw(own.bbox.yaw_rad + turn_rad)
            self.objects[row] = replace(own, bbox=replace(own.bbox, q=quat))

    def _turn_of(self, place: int) -> int:
        return turn_of(CATEGORY_IDS[self.program.kinds[place].category])

    def _below(self, bearer: int | None, node: str) -> list[int]:
        """Tokens of a node on an object; on the last of its token those of objects not there."""
        place, number = (0, 0) if bearer is None else self.place_of[bearer]
        if place is None:
            return []
        is_last = place == 0 or number == len(self.made[place]) - 1
        found = (i for i in self.children[place] if self.program.kinds[i].node == node)
        members = ((i, int(self.program.member[i])) for i in found)
        return [i for i, member in members if member == number or (is_last and member > number)]

    def _box(self, object_id: int | None) -> OrientedBox | None:
        return None if object_id is None else self.objects[object_id].bbox

    def _base_m(self, object_id: int | None) -> float:
        box = self._box(object_id)
        return 0.0 if box is None else box.p[2] - box.s[2] / 2

    def _outline(self, object_id: int | None) -> Rectangle:
        return self.site if object_id is None else footprint(self.objects[object_id].bbox)

    def _add_site(self, place: int) -> None:
        grown, widths = self.grower.head(place)
        tokens = cells(grown)
        plain = from_sequence([*widths, *grown.flat()])
        assert isinstance(plain, SitePartition)
        frame = plain.frame
        tree = settled(plain.tree, frame.length_m, frame.width_m, LEAST_COVER_M)
        for cover in build_site(replace(plain, tree=tree)):
            token, _ = tokens[cover.leaf]
            if token is None or cover.kind == VOID:
                continue
            word = Word.read(cover.kind)
            kind = self.program.kinds[token]
            parent = self.made[token][-1] if self.made[token] else None
            if parent is None and not kind.is_root:
                parent = self._under(cover.box, word)
            made = self._add(token, word.category, word.domain, dict(word.attributes), cover.box)
            self._set_parent(made, parent, bearer=None)

    def _under(self, box: OrientedBox, word: Word) -> int | None:
        """The cover that bears another; else the last before it of its category."""
        base_m = box.p[2] - box.s[2] / 2
        found: int | None = None
        for obj in self.objects:
            top_m = obj.bbox.p[2] + obj.bbox.s[2] / 2
            u_m, v_m, _ = footprint(obj.bbox).place.local(footprint(box).place)
            is_over = abs(u_m) <= obj.bbox.s[0] / 2 and abs(v_m) <= obj.bbox.s[1] / 2
            if abs(top_m - base_m) < _ON_M and is_over:
                return obj.id
            found = obj.id if obj.category == word.category else found
        return found

    def _add_storeys(self, host: int | None) -> None:
        """Rooms and walls of the storeys in an object."""
        storeys = self._below(host, "storey")
        if not storeys:
            return
        outline, base_m = self._outline(host), self._base_m(host)
        building = build_building(self.program, self.grower, storeys, outline, base_m)
        self.buildings[host] = building
        for part, token in building.parts:
            kind = Kind("leaf") if token is None else self.program.kinds[token]
            openings = {name: round(value, 4) for name, value in part.openings.items()}
            attributes = dict(kind.attributes) | openings
            made = self._add(token, part.category, "indoor", attributes, part.box)
            self._set_parent(made, host, bearer=host)
            air = air_of(part.box, attributes) if part.category == "wall" else None
            if air is not None:
                self.neighbours.add_air(air)

    def _add_unit(self, place: int, bearer: int | None) -> None:
        program = self.program
        kind = program.kinds[place]
        if kind.category in AFLOAT and self.standing.category(bearer) != "water":
            bearer = next((obj.id for obj in self.objects if obj.category == "water"), bearer)
        members = [i for i in self.children[place] if program.kinds[i].node == "member"]
        unit = read_unit(program, place, members, bearer, self.standing, self._outline, self._box)
        table = unit.host_id if unit.relation.kind == RelationKind.SEAT else None
        boxes = self._boxes(unit, kind)
        if table is not None:
            boxes = self._drawn_up(boxes, table)
        elif boxes and kind.category not in _FIXED:
            boxes = self._free(unit, kind, boxes)
        for box in boxes:
            is_slab = kind.category == "floor" and bearer in self.buildings
            if is_slab and self._is_upper(box, bearer):
                self.slabs.append((place, box))
                continue
            attributes = dict(kind.attributes) | _openings(program, place, box)
            laid = self._under_rooms(box, bearer) if is_slab else box
            made = self._add(place, kind.category, kind.domain, attributes, laid)
            self._set_parent(made, None if kind.is_root else bearer, bearer=bearer, table=table)

    def _is_upper(self, slab: OrientedBox, host: int | None) -> bool:
        """Whether a slab is one of a building's upper storeys."""
        levels = self.buildings[host].levels
        top_m = slab.p[2] + slab.s[2] / 2
        return bool(levels[1:]) and top_m - levels[0].base_m > _STOREY_M

    def _under_rooms(self, slab: OrientedBox, host: int | None) -> OrientedBox:
        """A slab at the level of the rooms of the first storey, where it is near that."""
        top_m = self.buildings[host].levels[0].base_m
        z_m = top_m - slab.s[2] / 2
        if not _SAME_M < abs(z_m - slab.p[2]) < _STOREY_M:
            return slab
        return replace(slab, p=(*slab.p[:2], z_m))

    def _lay_slabs(self, host: int | None) -> None:
        """Upper slabs as the rooms upon them ask for, in place of those that were drawn."""
        if not self.slabs:
            return
        drawn, self.slabs = self.slabs, []
        for slab in self.buildings[host].upper_slabs(len(drawn)):
            away_m = [math.dist(slab.p, box.p) for _, box in drawn]
            place = drawn[away_m.index(min(away_m))][0]
            kind = self.program.kinds[place]
            made = self._add(place, kind.category, kind.domain, dict(kind.attributes), slab)
            self._set_parent(made, None if kind.is_root else host, bearer=host)

    def _boxes(self, unit: Unit, kind: Kind) -> list[OrientedBox]:
        boxes = mended(kind.category, member_boxes(unit, self._box), self.objects)
        is_on_table = self.standing.category(unit.parent_id) in TABLES
        return laid_for(boxes, self.objects) if kind.category in LAID and is_on_table else boxes

    def _free(self, unit: Unit, kind: Kind, boxes: Sequence[OrientedBox]) -> list[OrientedBox]:
        """A unit's boxes where they have room: as its relation has it, or else nearby."""
        bearer = unit.parent_id
        taken = self.neighbours.taken(bearer)
        within = None if bearer is None else self._outline(bearer)
        for turns, ways in open_ways(unit, self._outline(unit.host_id)):
            side = (unit.relation.side + turns) % N_SIDES
            turned = replace(unit, relation=replace(unit.relation, side=side))
            found = self._boxes(turned, kind) if turns else boxes
            shift = free_shift(found, taken, within, ways) if found else None
            if shift is not None:
                return [moved(box, shift) for box in found]
        is_taken = clashing(boxes, taken)
        if sum(is_taken) > _MOST_LEFT_OUT * len(boxes):
            return list(boxes)
        return [box for box, clashes in zip(boxes, is_taken, strict=True) if not clashes]

    def _drawn_up(self, chairs: Sequence[OrientedBox], table: int) -> list[OrientedBox]:
        """Chairs that have room, their table moved with them where that makes it."""
        bearer = self.standing.bearer(table)
        taken = self.neighbours.taken(bearer, without=[table])
        own = self.objects[table].bbox
        within = None if bearer is None else self._outline(bearer)
        shift = free_shift([own, *chairs], taken, within, ways_rad=None)
        if shift is None:
            is_taken = clashing(chairs, taken)
            return [box for box, clashes in zip(chairs, is_taken, strict=True) if not clashes]
        self.objects[table] = replace(self.objects[table], bbox=moved(own, shift))
        self.neighbours.move(table, self.objects[table].bbox)
        return [moved(box, shift) for box in chairs]

    def _add(
        self,
        place: int | None,
        category: str,
        domain: str,
        attributes: dict[str, AttributeValue],
        box: OrientedBox,
    ) -> int:
        """Put an object at the end, as yet without a parent."""
        number = len(self.objects)
        looks: dict[str, AttributeValue] = {}
        if place is not None:
            drawn = self.program.looks[place] if self.program.looks else ()
            looks = drawn[min(len(self.made[place]), len(drawn) - 1)] if drawn else {}
            self.made[place].append(number)
        self.place_of.append((place, 0 if place is None else len(self.made[place]) - 1))
        own: ObjectDomain = "indoor" if domain == "indoor" else "outdoor"
        self.objects.append(
            SceneObject(
                id=number,
                scene_id="",
                parent_id=None,
                category_id=CATEGORY_IDS[category],
                bbox=box,
                domain=own,
                attributes=looks | attributes,
            )
        )
        return number

    def _set_parent(
        self, made: int, parent: int | None, *, bearer: int | None, table: int | None = None
    ) -> None:
        self.objects[made] = replace(self.objects[made], parent_id=parent)
        self.neighbours.add(self.objects[made].bbox, parent)
        self.standing.add(made, self.objects[made].category_id, bearer, table)


def _openings(program: Program, place: int, box: OrientedBox) -> dict[str, AttributeValue]:
    """Openings of a unit, within the wall that they are in."""
    values = dict(zip(OPENINGS, program.channels[place, OPENING].tolist(), strict=True))
    half_m = box.s[1] / 2
    found: dict[str, AttributeValue] = {}
    for name in program.kinds[place].openings:
        value = 0.0 if math.isnan(values[name]) else values[name]
        if name.endswith("offset_m"):
            width_m = values[name.replace("offset_m", "m")]
            play = max(0.0, 1.0 - (0.0 if math.isnan(width_m) else width_m) / 2 / half_m)
            value = min(max(value, -play), play) * half_m
        else:
            most_m = box.s[2] if "height" in name or "sill" in name else 2 * half_m
            value = min(max(value, 0.0), most_m)
        found[name] = round(value, 4)
    return found
