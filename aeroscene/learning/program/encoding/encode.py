"""Encoding of scenes: partitions first, then units on the objects that these make, in one tree."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import msgspec
import numpy as np
from jaxtyping import Float

from aeroscene.landform import level
from aeroscene.learning.program.clearances import gaps_between
from aeroscene.learning.program.companions import host_key
from aeroscene.learning.program.encoding.bearers import covers_under, find_boxes
from aeroscene.learning.program.encoding.cfg import WHOLE, EncodingCfg
from aeroscene.learning.program.encoding.partitions import Cells, site_node, storey_node
from aeroscene.learning.program.encoding.units import underside_m, unit_node, unit_size_m
from aeroscene.learning.program.kinds import (
    SiteKind,
    What,
    Word,
    looks,
    openings,
    scene_kind,
    shaping,
    what_of,
)
from aeroscene.learning.program.measures import BARE_SITE, site_rectangle
from aeroscene.learning.program.program import Node, Program, in_order, to_program
from aeroscene.partition import (
    ParsedBuilding,
    build_site,
    build_storeys,
    building_partitions,
    site_partition,
)
from aeroscene.relations import scene_relations
from aeroscene.relations.plane import Rectangle, footprint
from aeroscene.scene import OrientedBox, Scene, SceneObject, Vector3
from aeroscene.scene.catalogue import ROOMS


@dataclass(frozen=True, eq=False, kw_only=True)
class EncodedProgram:
    """A program with the objects that it was read from."""

    program: Program
    object_ids: tuple[tuple[int, ...], ...]
    """Ids of the objects that each token stands for."""
    choices: Float[np.ndarray, "n 4 4"]
    """Values of `REFERENCED` channels from each reference; NaN where one does not exist."""
    gaps: Mapping[str, Float[np.ndarray, "k 2"]]
    """Result of `gaps_between` for the units of each category."""
    hosts: tuple[str, ...]
    """Key of the host of each unit, see `companions`; empty for other tokens."""


def encode(scene: Scene, cfg: EncodingCfg = WHOLE) -> EncodedProgram:
    """Write a scene as a program.

    Boxes, categories, parents and shaping attributes are read, and nothing else. A scene with a
    relief is encoded as it lies on flat ground.

    Args:
        scene: Any scene.
        cfg: Details that the program keeps.

    Raises:
        PartitionError: If covers, rooms or walls overlap in a way that no partition has.
        ProgramError: If an object is not rebuilt from the partition that it was read into.
    """
    scene = level(scene)
    root = Node(scene_kind(scene.domain, scene.theme))
    encoder = _Encoder(scene, root, cfg)
    encoder.add_site()
    buildings = building_partitions(scene, Word.from_object) if cfg.has_partitions else []
    for building in buildings:
        encoder.add_building(building)
    # Units come after all partitions, because they stand on the objects of these.
    encoder.add_units()
    encoder.hang_storeys(buildings)
    nodes, _, _ = in_order(root)
    none = np.full((4, 4), np.nan)
    return EncodedProgram(
        program=to_program(root),
        object_ids=tuple(tuple(node.ids) for node in nodes),
        choices=np.array([none if node.choices is None else node.choices for node in nodes]),
        gaps=_gaps(nodes, scene),
        hosts=tuple(node.beside for node in nodes),
    )


def _gaps(nodes: Sequence[Node], scene: Scene) -> dict[str, Float[np.ndarray, "k 2"]]:
    units: defaultdict[str, list[list[OrientedBox]]] = defaultdict(list)
    for node in nodes:
        if node.kind.node == "unit":
            units[node.kind.category].append([scene.object_by_id[i].bbox for i in node.ids])
    return {category: gaps_between(found) for category, found in units.items() if len(found) > 1}


@dataclass(slots=True, eq=False)
class _Encoder:
    scene: Scene
    root: Node
    cfg: EncodingCfg
    site: Rectangle = field(default=BARE_SITE)
    given: list[int] = field(default_factory=list)
    """Ids of the objects that partitions make, in the order in which they are built."""
    bearer: dict[int | None, tuple[Node, int]] = field(default_factory=dict)
    """Node of each object, and the object's number among those of the node."""
    storeys: list[list[Node]] = field(default_factory=list)
    """Nodes of the storeys of each building."""

    def add_site(self) -> None:
        """Add the covers of the ground."""
        self.bearer[None] = self.root, 0
        parsed = site_partition(self.scene, Word.from_object) if self.cfg.has_partitions else None
        if parsed is None:
            return
        head, cells = site_node(parsed.site)
        assert isinstance(head.kind, SiteKind)
        self.root.add(head)
        self.site = site_rectangle(head.kind, head.channels)
        covers = build_site(parsed.site)
        boxes = [cover.box for cover in covers]
        found = find_boxes(boxes, [self._object(each) for each in sorted(parsed.object_ids)])
        for cover, obj in zip(covers, found, strict=True):
            self._stand_for(obj, *cells[cover.leaf])
            node = self.bearer[obj.id][0]
            if len(node.ids) == 1 and obj.parent_id is None:
                node.kind = msgspec.structs.replace(node.kind, is_root=True)

    def add_building(self, parsed: ParsedBuilding) -> None:
        """Add the rooms and walls of a building's storeys."""
        host = self.site
        below_m = 0.0
        if parsed.host_id is not None:
            shell = self._object(parsed.host_id).bbox
            host, below_m = footprint(shell), underside_m(shell)
        nodes: list[Node] = []
        cells: list[Cells] = []
        borders: list[list[Node]] = []
        for storey in parsed.storeys:
            made = storey_node(storey, host, below_m, is_first=not nodes)
            nodes.append(made[0])
            cells.append(made[1])
            borders.append(made[2])
            # The next storey's level counts from this one's.
            below_m = storey.level_m
        self.storeys.append(nodes)
        parts = build_storeys(parsed.storeys)
        found = find_boxes(
            [part.box for part in parts], [self._object(i) for i in sorted(parsed.object_ids)]
        )
        for part, obj in zip(parts, found, strict=True):
            if part.category in ROOMS:
                self._stand_for(obj, *cells[part.storey][part.place])
            else:
                self._stand_for(obj, borders[part.storey][part.place], 0)

    def _stand_for(self, obj: SceneObject, node: Node, piece: int) -> None:
        # A merged leaf and each piece of a lane are several objects of one node.
        self.bearer[obj.id] = node, max(piece, len(node.ids))
        self.given.append(obj.id)
        node.ids.append(obj.id)
        node.looks.append(looks(obj))

    def add_units(self) -> None:
        """Add all other objects below their bearers."""
        scene = self.scene
        view = self._view()
        objects = view.object_by_id
        roots = frozenset(obj.id for obj in scene.objects if obj.parent_id is None)
        with_rooms = {obj.parent_id for obj in scene.objects if obj.category in ROOMS}

        def alike(obj: SceneObject) -> Hashable:
            # Objects with openings or rooms of their own cannot be members of a group.
            is_single = openings(obj) or obj.id in with_rooms
            return obj.category, obj.domain, shaping(obj), obj.id if is_single else None

        last_m: dict[What, Vector3] = {}
        is_related = self.cfg.has_relations
        for unit in scene_relations(view, self.given, alike, is_related=is_related):
            what = what_of(objects[unit.members[0].id])
            node = unit_node(unit, objects, self.site, roots, last_m.get(what))
            last_m[what] = unit_size_m(unit)
            node.beside = self._host_key(unit.host_id)
            above, node.member = self.bearer[unit.parent_id]
            above.add(node)
            for number, member in enumerate(unit.members):
                self.bearer[member.id] = node, number

    def _host_key(self, host_id: int | None) -> str:
        if host_id is None:
            return host_key("", "")
        return host_key(self._object(host_id).category, self.bearer[host_id][0].kind.relation)

    def hang_storeys(self, buildings: Sequence[ParsedBuilding]) -> None:
        """Hang storeys below their buildings, before everything else there."""
        for building, nodes in zip(buildings, self.storeys, strict=True):
            above, member = self.bearer[building.host_id]
            for node in nodes:
                node.member = member
            # Storeys are built before the units of their building.
            above.children[:0] = nodes

    def _view(self) -> Scene:
        """Return the scene in which objects on a cover, without a parent, are its children."""
        under = covers_under(self.scene, self.given)
        first = [replace(self._object(i), parent_id=None) for i in self.given if i in under.covers]
        known = {obj.id for obj in first}
        rest = [
            replace(obj, parent_id=under.bearer.get(obj.id, obj.parent_id))
            for obj in self.scene.objects
            if obj.id not in known
        ]
        return replace(self.scene, objects=(*first, *rest), interaction_areas=())

    def _object(self, object_id: int) -> SceneObject:
        return self.scene.object_by_id[object_id]
