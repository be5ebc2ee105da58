"""Reads the relations of a scene off its boxes, categories and parents."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace

from aeroscene.relations.hosts import SEATS, VEHICLES, AT_ROADS, Standing, is_furniture
from aeroscene.relations.parsing import fits
from aeroscene.relations.parsing.arrays import find_lattices
from aeroscene.relations.parsing.seating import find_seats
from aeroscene.relations.placing import array_half_m, cell_places, levels_m, residual_of
from aeroscene.relations.plane import WORLD, Rectangle, footprint
from aeroscene.relations.relation import Array, Kind, Member, Relation, Residual, Unit
from aeroscene.scene import OrientedBox, Scene, SceneObject
from aeroscene.scene.box import quat_from_yaw, quat_product

_Candidate = tuple[Relation, int | None]


def scene_relations(scene: Scene) -> tuple[Unit, ...]:
    """What the fine objects of a scene are to their hosts, in drawing order.

    Parents come before what stands on them, and of what has one parent the larger first, chairs
    last, so that a host always comes before what refers to it. Only boxes, categories and parents
    are read. `aeroscene.relations.placing.place` gives the boxes back.
    """
    return tuple(_Reader(scene).units())


class _Reader:
    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._outline = {obj.id: footprint(obj.bbox) for obj in scene.objects}
        coarse = tuple(obj for obj in scene.objects if obj.is_coarse)
        self._standing = Standing(coarse)
        self._queue: list[int | None] = [None, *(obj.id for obj in coarse)]

    def units(self) -> Iterator[Unit]:
        """Units parent by parent; what they bear follows later."""
        for parent_id in self._queue:
            children = self._scene.children_by_id.get(parent_id, ())
            fine = [child for child in children if not child.is_coarse]
            for unit in self._units_on(parent_id, fine) if fine else ():
                self._let_stand(unit)
                yield unit

    def _let_stand(self, unit: Unit) -> None:
        table = unit.host_id if unit.relation.kind == Kind.SEAT else None
        for member in unit.members:
            self._standing.add(member.id, member.category_id, unit.parent_id, table)
            self._queue.append(member.id)

    def _units_on(self, parent_id: int | None, fine: list[SceneObject]) -> Iterator[Unit]:
        """Units of one parent: rows and grids and single things by size, then chairs."""
        chairs = [obj for obj in fine if obj.category in SEATS]
        groups = self._arranged([obj for obj in fine if obj.category not in SEATS], parent_id)
        for objects, array, outline in sorted(groups, key=_by_size):
            yield self._unit(parent_id, objects, array, outline)
        left = []
        hosts = self._standing.possible_hosts(Kind.SEAT, chairs[0].category_id, parent_id) if chairs else []
        tables = {host: self._outline[host] for host in hosts if host is not None}
        seatings, lone = find_seats(tables, [(obj.id, self._outline[obj.id]) for obj in chairs])
        for seating in seatings:
            objects = [self._scene.object_by_id[member] for member in seating.members]
            relation = replace(seating.relation, host=hosts.index(seating.table_id))
            yield self._finished(
                parent_id, seating.table_id, relation, objects, seating.array, seating.residual
            )
        left = [self._scene.object_by_id[chair] for chair in lone]
        for objects, array, outline in sorted(self._arranged(left, parent_id), key=_by_size):
            yield self._unit(parent_id, objects, array, outline)

    def _arranged(
        self, objects: list[SceneObject], parent_id: int | None
    ) -> list[tuple[list[SceneObject], Array | None, Rectangle]]:
        """Rows and grids of one kind, and what is in none."""
        found: list[tuple[list[SceneObject], Array | None, Rectangle]] = []
        kinds: defaultdict[int, list[SceneObject]] = defaultdict(list)
        for obj in objects:
            kinds[obj.category_id].append(obj)
        parent = None if parent_id is None else self._scene.object_by_id[parent_id]
        for alike in kinds.values():
            taken: set[int] = set()
            on_top = parent is not None and is_furniture(parent.category_id)
            lattices = [] if on_top else find_lattices([self._outline[o.id] for o in alike])
            for lattice in lattices:
                members = [alike[index] for index in lattice.members]
                half_m = array_half_m(lattice.array, [obj.bbox.s for obj in members])
                found.append((members, lattice.array, Rectangle(lattice.middle, half_m)))
                taken.update(obj.id for obj in members)
            found += [([o], None, self._outline[o.id]) for o in alike if o.id not in taken]
        return found

    def _unit(
        self,
        parent_id: int | None,
        objects: list[SceneObject],
        array: Array | None,
        outline: Rectangle,
    ) -> Unit:
        candidates = list(self._candidates(parent_id, objects[0], outline))
        relation, host_id = max(candidates, key=_preference)
        residual = residual_of(relation, self._host(host_id), outline)
        return self._finished(parent_id, host_id, relation, objects, array, residual)

    def _candidates(
        self, parent_id: int | None, obj: SceneObject, outline: Rectangle
    ) -> Iterator[_Candidate]:
        """Relations that hold, each with its host and the host's rank."""
        parent = self._host(parent_id)
        is_top = parent_id is not None and is_furniture(
            self._scene.object_by_id[parent_id].category_id
        )
        yield fits.scatter(parent, outline, Kind.ON if is_top else Kind.SCATTER), parent_id
        if parent_id is not None:
            for relation in fits.inside(parent, outline, is_top=is_top):
                yield relation, parent_id
        kinds = [Kind.SIDE] if is_top or obj.category in AT_ROADS else [Kind.SIDE, Kind.OVER, Kind.FACING]
        kinds += [Kind.LANE] if obj.category in VEHICLES else []
        for kind in kinds:
            hosts = self._standing.possible_hosts(kind, obj.category_id, parent_id)
            for rank, host_id in enumerate(hosts):
                for relation in _fits(kind, self._host(host_id), outline, obj):
                    yield replace(relation, host=rank), host_id

    def _host(self, host_id: int | None) -> Rectangle:
        return WORLD if host_id is None else self._outline[host_id]

    def _finished(
        self,
        parent_id: int | None,
        host_id: int | None,
        relation: Relation,
        objects: Sequence[SceneObject],
        array: Array | None,
        residual: Residual,
    ) -> Unit:
        """The unit, with what each member's place adds to it."""
        parent = None if parent_id is None else self._scene.object_by_id[parent_id].bbox
        unit = Unit(
            parent_id=parent_id,
            host_id=host_id,
            relation=relation,
            members=tuple(_member(obj, parent) for obj in objects),
            array=array,
            residual=residual,
        )
        if array is None:
            return unit
        cells = cell_places(unit, self._host(host_id))
        members = tuple(
            replace(member, residual=Residual(*cell.local(self._outline[member.id].place)))
            for member, cell in zip(unit.members, cells, strict=True)
        )
        return replace(unit, members=members)


def _by_size(group: tuple[list[SceneObject], Array | None, Rectangle]) -> tuple[float, int, int]:
    first = group[0][0]
    area_m2 = first.bbox.s[0] * first.bbox.s[1]
    return -round(area_m2, 3), first.category_id, first.id


def _fits(
    kind: Kind, host: Rectangle, outline: Rectangle, obj: SceneObject
) -> Iterator[Relation]:
    match kind:
        case Kind.LANE:
            return fits.lane(host, outline)
        case Kind.OVER:
            return fits.over(host, outline)
        case Kind.FACING:
            return fits.facing(host, outline)
        case _:
            return fits.beside(host, outline, is_far=obj.category in AT_ROADS)


def _preference(candidate: _Candidate) -> tuple[int, int, int, int]:
    """Most axes pinned first, then the order of the kinds, then a heading, then the likeliest host."""
    relation, _ = candidate
    is_pinned = relation.pinned
    return is_pinned[0] + is_pinned[1], -relation.kind, is_pinned[2], -relation.host


def _member(obj: SceneObject, parent: OrientedBox | None) -> Member:
    box = obj.bbox
    low_m, top_m = (0.0, 0.0) if parent is None else levels_m(parent)
    base_m = levels_m(box)[0]
    is_on_top = abs(base_m - top_m) <= abs(base_m - low_m)
    tilt = None
    if not box.is_upright:
        w, _, _, z = quat_from_yaw(box.yaw_rad)
        a, b, c, d = quat_product((w, 0.0, 0.0, -z), box.q)
        tilt = (a, b, c, d)
    return Member(
        id=obj.id,
        category_id=obj.category_id,
        size_m=box.s,
        is_on_top=is_on_top,
        rise_m=base_m - (top_m if is_on_top else low_m),
        tilt_wxyz=tilt,
    )
