"""Reading of a scene's relations off its boxes, categories and parents."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass, replace

from aeroscene.relations.hosts import N_TURNS, Standing, turn_of
from aeroscene.relations.parsing.priority import Ground, best_relation
from aeroscene.relations.parsing.rows import find_lattices
from aeroscene.relations.parsing.seating import find_seats
from aeroscene.relations.placement import array_half_m, cell_places, levels_m, residual_of
from aeroscene.relations.plane import Rectangle
from aeroscene.relations.relation import Array, Kind, Member, Relation, Residual, Unit
from aeroscene.scene import OrientedBox, Scene, SceneObject
from aeroscene.scene.box import quat_from_yaw, quat_product
from aeroscene.scene.catalogue import SEATS

Alike = Callable[[SceneObject], Hashable]


def _category(obj: SceneObject) -> Hashable:
    return obj.category_id


def scene_relations(
    scene: Scene,
    given: Sequence[int] | None = None,
    alike: Alike = _category,
    *,
    is_related: bool = True,
) -> tuple[Unit, ...]:
    """Read the relations of a scene's objects to their hosts, in drawing order.

    Coarse objects come first, then stairs, then fine ones. Parents come before the objects on them.
    Of the objects on one parent the larger come first and chairs last, so that a host always comes
    before the objects that refer to it. Only boxes, categories and parents are read.
    `aeroscene.relations.placement.place` gives the boxes back.

    Args:
        scene: Any scene.
        given: Ids of the objects that need no relation, in the order in which they stand; by
            default all coarse ones.
        alike: Key that objects of one row or grid share, their category at least.
        is_related: True looks for relations. Otherwise each object is by itself, at its place on
            its bearer.
    """
    if given is None:
        given = [obj.id for obj in scene.objects if obj.is_coarse]
    return tuple(_Reader(scene, given, alike, is_related=is_related).units())


@dataclass(frozen=True, slots=True)
class _Group:
    """Objects that are drawn at once, before their relation is known."""

    objects: Sequence[SceneObject]
    array: Array | None
    outline: Rectangle

    @property
    def order(self) -> tuple[bool, float, int, int]:
        """Sorting key: coarse objects first, then by size."""
        first = self.objects[0]
        area_m2 = first.bbox.s[0] * first.bbox.s[1]
        # Rounded, so that equal objects stay in the order of their ids.
        return not first.is_coarse, -round(area_m2, 3), first.category_id, first.id


class _Reader:
    def __init__(
        self, scene: Scene, given: Sequence[int], alike: Alike, *, is_related: bool
    ) -> None:
        self._scene, self._alike, self._is_related = scene, alike, is_related
        standing = Standing(tuple(scene.object_by_id[each] for each in given))
        self._ground = Ground(scene, standing)
        self._rank = {object_id: rank for rank, object_id in enumerate(given)}
        self._drawn = set(given)
        self._queue: list[int | None] = []

    def units(self) -> Iterator[Unit]:
        """Yield units turn by turn and parent by parent; objects on them follow later."""
        self._queue.append(None)
        n_reached = 0
        for turn in range(N_TURNS):
            # The queue grows while it is walked through: new objects are bearers, too.
            for number, parent_id in enumerate(self._queue):
                children = self._scene.children_by_id.get(parent_id, ())
                if number >= n_reached:
                    given = (child.id for child in children if child.id in self._rank)
                    # Given objects are no units, but they bear others.
                    self._queue += sorted(given, key=self._rank.__getitem__)
                    n_reached += 1
                due = [child for child in children if self._is_due(child, turn)]
                for unit in self._units_on(parent_id, due) if due else ():
                    self._let_stand(unit)
                    yield unit

    def _is_due(self, obj: SceneObject, turn: int) -> bool:
        return obj.id not in self._drawn and turn_of(obj.category_id) <= turn

    def _let_stand(self, unit: Unit) -> None:
        table = unit.host_id if unit.relation.kind == Kind.SEAT else None
        for member in unit.members:
            self._ground.standing.add(member.id, member.category_id, unit.parent_id, table)
            self._queue.append(member.id)
            self._drawn.add(member.id)

    def _units_on(self, parent_id: int | None, objects: list[SceneObject]) -> Iterator[Unit]:
        """Yield the units of one parent: rows, grids and single objects by size, then chairs."""
        if not self._is_related:
            yield from self._strewn(objects, parent_id)
            return
        yield from self._related([obj for obj in objects if obj.category not in SEATS], parent_id)
        chairs = {obj.id: obj for obj in objects if obj.category in SEATS}
        if not chairs:
            return
        # All chairs of a parent have the same possible tables.
        category_id = next(iter(chairs.values())).category_id
        hosts = self._ground.standing.possible_hosts(Kind.SEAT, category_id, parent_id)
        tables = {host: self._ground.outline(host) for host in hosts if host is not None}
        outlines = {chair: self._ground.outline(chair) for chair in chairs}
        for seating in find_seats(tables, outlines):
            seated = [chairs.pop(member) for member in seating.members]
            group = _Group(seated, seating.array, outlines[seated[0].id])
            relation = replace(seating.relation, host=hosts.index(seating.table_id))
            yield self._unit(group, relation, seating.table_id, seating.residual)
        yield from self._related(list(chairs.values()), parent_id)

    def _related(self, objects: Sequence[SceneObject], parent_id: int | None) -> Iterator[Unit]:
        """Yield units with the relation that their outlines have."""
        for group in sorted(self._groups(objects, parent_id), key=lambda group: group.order):
            relation, host_id = best_relation(self._ground, group.objects[0], group.outline)
            residual = residual_of(relation, self._ground.outline(host_id), group.outline)
            yield self._unit(group, relation, host_id, residual)

    def _strewn(self, objects: Sequence[SceneObject], parent_id: int | None) -> Iterator[Unit]:
        """Yield each object by itself, somewhere on its bearer."""
        groups = [_Group([obj], None, self._ground.foot(obj)) for obj in objects]
        relation = Relation(kind=Kind.SCATTER)
        for group in sorted(groups, key=lambda group: group.order):
            residual = residual_of(relation, self._ground.outline(parent_id), group.outline)
            yield self._unit(group, relation, parent_id, residual)

    def _groups(self, objects: Sequence[SceneObject], parent_id: int | None) -> Iterator[_Group]:
        """Yield rows and grids of one kind, and the objects that are in none."""
        kinds: defaultdict[Hashable, list[SceneObject]] = defaultdict(list)
        for obj in objects:
            kinds[self._alike(obj)].append(obj)
        for alike in kinds.values():
            feet = [self._ground.foot(obj) for obj in alike]
            left = set(range(len(alike)))
            # Objects on furniture are laid by seats or strewn, so rows among them are chance.
            is_top = self._ground.is_top(parent_id)
            for lattice in [] if is_top else find_lattices(feet):
                members = [alike[index] for index in lattice.members]
                half_m = array_half_m(lattice.array, [feet[i].half_m for i in lattice.members])
                yield _Group(members, lattice.array, Rectangle(lattice.middle, half_m))
                left -= set(lattice.members)
            for index in sorted(left):
                yield _Group([alike[index]], None, feet[index])

    def _unit(
        self, group: _Group, relation: Relation, host_id: int | None, residual: Residual
    ) -> Unit:
        """Return the unit, with the difference of each member's place from its cell."""
        parent_id = group.objects[0].parent_id
        parent = None if parent_id is None else self._scene.object_by_id[parent_id].bbox
        unit = Unit(
            parent_id=parent_id,
            host_id=host_id,
            relation=relation,
            members=tuple(_member(obj, parent) for obj in group.objects),
            array=group.array,
            residual=residual,
        )
        if unit.array is None:
            return unit
        cells = cell_places(unit, self._ground.outline(host_id))
        places = [self._ground.outline(member.id).place for member in unit.members]
        members = tuple(
            replace(member, residual=Residual(*cell.local(place)))
            for member, cell, place in zip(unit.members, cells, places, strict=True)
        )
        return replace(unit, members=members)


def _member(obj: SceneObject, parent: OrientedBox | None) -> Member:
    """Return an object by itself, its height from the nearer of its parent's top and underside."""
    box = obj.bbox
    low_m, top_m = levels_m(parent)
    base_m, _ = levels_m(box)
    is_on_top = abs(base_m - top_m) <= abs(base_m - low_m)
    tilt = None
    if not box.is_upright:
        w, _, _, z = quat_from_yaw(box.yaw_rad)
        # The heading is removed from the left; a rotation about tilted axes remains.
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
