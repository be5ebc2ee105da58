"""Decoding of programs: covers, then objects on them, storeys in buildings, and so on downwards.

Every program gives a scene, so that a draw of a model needs no luck. Objects are built from the
ground up, because the bearer of an object must be there before it. A program that was read off a
scene gives that scene back. The modules of `structures` and `units` say how they treat objects that
do not fit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from aeroscene.feasibility.boxes import boxes_of
from aeroscene.feasibility.doors import air_of
from aeroscene.feasibility.place_search import Blocks
from aeroscene.feasibility.seats import turns_to_tables
from aeroscene.feasibility.traffic import turns_with_traffic
from aeroscene.learning.program.decoding.cfg import DecodingCfg
from aeroscene.learning.program.decoding.draft import Draft
from aeroscene.learning.program.decoding.draft.neighbours import (
    free_of,
    free_shift,
    moved,
    open_ways,
    turned,
)
from aeroscene.learning.program.decoding.draft.supports import drawn_in, laid_for, mended
from aeroscene.learning.program.decoding.structures.buildings import DecodedBuilding, build_building
from aeroscene.learning.program.decoding.structures.overhead import Overhead
from aeroscene.learning.program.decoding.structures.sites import add_site
from aeroscene.learning.program.decoding.units.backs import asks_for_wall, has_wall
from aeroscene.learning.program.decoding.units.groups import back_to_back, backed_by, drawn_up
from aeroscene.learning.program.decoding.units.reading import (
    member_boxes,
    openings_of,
    read_unit,
    with_own_sizes,
)
from aeroscene.learning.program.encoding.units import unit_size_m
from aeroscene.learning.program.flight import extent_of, start_pad, top_of, yaw_inwards
from aeroscene.learning.program.kinds import CATEGORY_IDS, Kind, What, theme_of
from aeroscene.learning.program.program import Program
from aeroscene.relations import Kind as RelationKind
from aeroscene.relations import Unit
from aeroscene.relations.hosts import N_TURNS, turn_of
from aeroscene.scene import OrientedBox, Scene, Vector3
from aeroscene.scene.box import quat_from_yaw
from aeroscene.scene.catalogue import (
    AFLOAT,
    BUILDING_PARTS,
    FLOORS,
    GROUND,
    POSTS,
    ROOFS,
    ROOMS,
    SETTINGS,
    STAIRS,
    TABLES,
    WALLS,
    WATER,
)
from aeroscene.scene.origin import ALTITUDE_M, LATITUDE_DEG, LONGITUDE_DEG

_FIXED = GROUND | BUILDING_PARTS | STAIRS | POSTS
"""Categories that stay where they were drawn, whatever else is there."""
_HOLDING = GROUND | ROOMS
"""Categories that hold everything drawn on or in them."""
_INNER = 0.5
"""Share of length and width about the middle that must be free, so that an object is not deep in
others."""


@dataclass(frozen=True, eq=False, kw_only=True)
class DecodedProgram:
    """A scene, and the ids of the objects that each token stands for."""

    scene: Scene
    object_ids: tuple[tuple[int, ...], ...]


def decode(
    program: Program, scene_id: str = "program", seed: int = 0, cfg: DecodingCfg | None = None
) -> DecodedProgram:
    """Build the scene of a program, without interaction areas.

    Args:
        program: Any program, whatever its numbers.
        scene_id: Name of the scene.
        seed: Seed that the scene states.
        cfg: Corrections of the program; None makes all of them.
    """
    builder = Builder(program, cfg)
    builder.build()
    draft = builder.draft
    low, high = extent_of(draft.objects, program.kinds[0].domain)
    draft.let_tiles_bear()
    objects = tuple(replace(obj, scene_id=scene_id) for obj in draft.objects)
    pad = start_pad(objects)
    start = (0.0, 0.0, 0.0) if pad is None else top_of(pad)
    start = np.clip(start, low, high).tolist()
    domain = program.kinds[0].domain
    scene = Scene(
        scene_id=scene_id,
        domain="indoor" if domain == "indoor" else "mixed" if domain == "mixed" else "outdoor",
        seed=seed,
        extent_min_enu_m=low,
        extent_max_enu_m=high,
        start_position_enu_m=(start[0], start[1], start[2]),
        start_yaw_rad=yaw_inwards(start),
        latitude_deg=LATITUDE_DEG,
        longitude_deg=LONGITUDE_DEG,
        altitude_m=ALTITUDE_M,
        objects=objects,
        theme=theme_of(program.kinds[0]),
    )
    return DecodedProgram(scene=scene, object_ids=tuple(map(tuple, draft.made)))


class Builder:
    """Builds a scene object by object."""

    def __init__(self, program: Program, cfg: DecodingCfg | None = None) -> None:
        self._program = with_own_sizes(program)
        self._cfg = cfg or DecodingCfg()
        self.draft = Draft(self._program)
        self._buildings: dict[int | None, DecodedBuilding] = {}
        """Buildings with storeys, by the object that they are in."""
        self._overhead = Overhead()
        self._n_given = 0
        """Number of objects that stand already and do not move."""
        self._last_m: dict[What, Vector3] = {}
        """Extents of the last unit of each key, which the next may copy."""

    def build(self) -> None:
        """Build everything from the ground up, in turns and in the order of reading.

        If any objects are given, then all objects that partitions make are given too.
        """
        draft, kinds = self.draft, self._program.kinds
        n_given = self._n_given = len(draft.objects)
        n_built = 1
        if not n_given:
            self._add_storeys(None)
            for place in draft.children[0]:
                if kinds[place].node == "site":
                    add_site(draft, place, self._buildings.get(None))
        # The queue grows while it is walked through: new objects may bear others.
        queue: list[int | None] = [None, *range(len(draft.objects))]
        # Chairs come in the last turn, when the tables that they stand at have their places.
        for turn in range(N_TURNS):
            for number, bearer in enumerate(queue):
                before = len(draft.objects)
                if number >= n_built and not n_given:
                    self._add_storeys(bearer)
                    n_built += 1
                for place in draft.below(bearer, "unit"):
                    # This turn also includes units of earlier turns whose bearer is new.
                    if turn_of(CATEGORY_IDS[kinds[place].category]) > turn:
                        continue
                    if not draft.made[place]:
                        self._add_unit(place, bearer)
                    # Given units count as the last of their key, for units that copy extents.
                    elif draft.made[place][0] < n_given:
                        given = draft.objects[draft.made[place][0]]
                        self._last_m[kinds[place].what] = given.bbox.s
                self._lay_slabs(bearer)
                queue += range(before, len(draft.objects))
        if self._cfg.mends:
            self._turn()

    def _turn(self) -> None:
        """Turn chairs to their tables, and vehicles with the traffic."""
        draft = self.draft
        objects = draft.objects
        known = objects, boxes_of(objects), np.ones(len(objects), dtype=bool)
        for row, turn_rad in [*turns_to_tables(*known), *turns_with_traffic(*known)]:
            box = objects[row].bbox
            draft.move(row, replace(box, q=quat_from_yaw(box.yaw_rad + turn_rad)))

    def _add_storeys(self, host: int | None) -> None:
        """Build rooms and walls of the storeys in an object."""
        draft = self.draft
        storeys = draft.below(host, "storey")
        if not storeys:
            return
        outline, base_m = draft.outline(host), draft.base_m(host)
        building = build_building(self._program, draft.trees, storeys, outline, base_m)
        if host is None:
            building = building.with_one_ceiling()
        self._buildings[host] = building
        for part, token in building.parts:
            openings = {name: round(value, 4) for name, value in part.openings.items()}
            known = () if token is None else self._program.kinds[token].attributes
            attributes = dict(known) | openings
            draft.add(
                token, part.category, "indoor", attributes, part.box, parent=host, bearer=host
            )
            # Doors need the air before them: no object may stand there.
            air = air_of(part.box, attributes) if part.category in WALLS else None
            if air is not None:
                draft.neighbours.add_air(air)

    def _add_unit(self, place: int, bearer: int | None) -> None:
        program, draft = self._program, self.draft
        kind = program.unit(place)
        # A boat that was drawn on land goes to the first water.
        if kind.category in AFLOAT and draft.standing.category(bearer) not in WATER:
            bearer = next((obj.id for obj in draft.objects if obj.category in WATER), bearer)
        is_roof = kind.category in ROOFS and bearer is None and bearer in self._buildings
        # A house with storeys has one roof; further ones are not built.
        if is_roof and self._overhead.has_roof:
            return
        rounds = self._cfg.rounds and kind.category not in GROUND
        unit = read_unit(draft, place, bearer, self._last_m.get(kind.what), rounds=rounds)
        self._last_m[kind.what] = unit_size_m(unit)
        if unit.array is not None:
            draft.pitches_m[place] = unit.array.pitch_m
        table = unit.host_id if unit.relation.kind == RelationKind.SEAT else None
        boxes = self._boxes(unit, kind)
        if self._cfg.makes_room and boxes:
            boxes = self._with_its_room(unit, kind, boxes, table)
        building = self._buildings.get(bearer) if kind.category in FLOORS else None
        for box in boxes:
            if is_roof:
                self._overhead.roofs.append((place, box))
                continue
            if building is not None and building.is_upper(box):
                self._overhead.slabs.append((place, box))
                continue
            draft.add(
                place,
                kind.category,
                kind.domain,
                dict(kind.attributes) | openings_of(program, place, box),
                box if building is None else building.under_rooms(box),
                parent=None if kind.is_root else bearer,
                bearer=bearer,
                table=table,
            )

    def _lay_slabs(self, host: int | None) -> None:
        """Lay upper slabs and roofs as rooms and walls need them, in place of the drawn ones."""
        building = self._buildings.get(host)
        for place, slab in [] if building is None else self._overhead.laid(building):
            kind = self._program.unit(place)
            parent = None if kind.is_root else host
            attributes = dict(kind.attributes)
            self.draft.add(
                place, kind.category, kind.domain, attributes, slab, parent=parent, bearer=host
            )

    def _boxes(self, unit: Unit, kind: Kind) -> list[OrientedBox]:
        """Return the boxes of a unit by its relation, without those that have no place."""
        draft = self.draft
        boxes = member_boxes(unit, draft.box)
        if not self._cfg.mends:
            return boxes
        boxes = mended(kind.category, boxes, draft.objects)
        bearer = draft.standing.category(unit.parent_id)
        if unit.parent_id is not None and bearer in _HOLDING and kind.category not in _FIXED:
            return drawn_in(boxes, draft.tiles(unit.parent_id))
        is_laid = kind.category in SETTINGS and bearer in TABLES
        return laid_for(boxes, draft.objects) if is_laid else boxes

    def _with_its_room(
        self, unit: Unit, kind: Kind, boxes: Sequence[OrientedBox], table: int | None
    ) -> list[OrientedBox]:
        """Return a unit's boxes in a free place, together with its group or by itself."""
        draft = self.draft
        if table is not None:
            return drawn_up(draft, boxes, table, self._n_given)
        if kind.category in _FIXED:
            return list(boxes)
        others = backed_by(draft, unit)
        found = back_to_back(draft, unit, others, self._n_given) if others else None
        return self._free(unit, kind, boxes) if found is None else found

    def _free(self, unit: Unit, kind: Kind, boxes: Sequence[OrientedBox]) -> list[OrientedBox]:
        """Return a unit's boxes where they have room: by the relation, or else nearby.

        Places count first that keep the clearance of the category. If there is no room for all
        boxes, those remain that have some, or at least are not deep in others. The start pad always
        stays.
        """
        draft, neighbours = self.draft, self.draft.neighbours
        taken = draft.taken(unit.parent_id)
        clearance_m = self._program.clearances.of(kind.category)
        tries: list[tuple[Blocks, int | None]] = [(taken, None)]
        if any(clearance_m):
            # Clearances are wishes, so only the first way is tried with them.
            kept_free = neighbours.kept_free(kind.category, clearance_m)
            tries.insert(0, (np.concatenate([taken, kept_free]), 1))
        is_backed = self._cfg.mends and asks_for_wall(draft, unit, kind.category)
        for needs_wall in (True, False) if is_backed else (False,):
            for full, n_ways in tries:
                found = self._with_room(unit, kind, boxes, full, n_ways, needs_wall=needs_wall)
                if found is not None:
                    return found
        things = draft.taken(unit.parent_id, has_air=False)
        found = free_of(taken, boxes) or free_of(things, boxes, _INNER)
        return found or [box for box in boxes if dict(kind.attributes).get("is_start")]

    def _with_room(
        self,
        unit: Unit,
        kind: Kind,
        boxes: Sequence[OrientedBox],
        taken: Blocks,
        n_ways: int | None,
        *,
        needs_wall: bool,
    ) -> list[OrientedBox] | None:
        """Return a unit's boxes by the first way that has room; None if none has."""
        draft = self.draft
        within = draft.extent(unit.parent_id)
        for turns, ways in islice(open_ways(unit, draft.outline(unit.host_id)), n_ways):
            tried = turned(unit, turns)
            found = self._boxes(tried, kind) if turns else boxes
            shift = free_shift(found, taken, within, ways) if found else None
            if shift is None:
                continue
            found = [moved(box, shift) for box in found]
            is_borne = draft.is_borne(unit.parent_id, found)
            if is_borne and (not needs_wall or has_wall(draft, tried, found)):
                return found
        return None
