"""Units as nodes of a program: an object, or a group of equal ones, in relation to its host."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from aeroscene.learning.program.kinds import (
    AS_LAST_AXES,
    OPENINGS,
    AsLast,
    MemberKind,
    UnitKind,
    looks,
    openings,
    shaping,
)
from aeroscene.learning.program.measures import (
    Surroundings,
    choices_of,
    reach_of,
    scales,
    up_to_level,
)
from aeroscene.learning.program.program import (
    COS,
    OPENING,
    PITCH,
    RISE,
    SIN,
    SIZE,
    TILT,
    Node,
    Shape,
    U,
    V,
)
from aeroscene.relations import Unit
from aeroscene.relations.placement import array_half_m, foot_m
from aeroscene.relations.plane import QUARTER, Half, Rectangle, footprint
from aeroscene.relations.relation import ANY_TURN, Residual
from aeroscene.relations.relation import Kind as RelationKind
from aeroscene.scene import OrientedBox, SceneObject, Vector3

SAME_M = 0.002
"""Differences below this do not count: members of a group need no numbers of their own, and a unit
copies the extents of the last."""
SAME_RAD = math.radians(0.05)
"""Headings that are off quarter turns by less are not turned."""


def unit_node(
    unit: Unit,
    objects: Mapping[int, SceneObject],
    site: Rectangle,
    roots: frozenset[int],
    last_m: Vector3 | None = None,
) -> Node:
    """Return the node of a unit, with a child for each member if members differ.

    Args:
        unit: The unit.
        objects: All objects of the scene under their ids.
        site: The scene from above: the host of objects without one.
        roots: Ids of the objects that have no parent in the scene.
        last_m: Extents of the last unit with the same key; None for the first one.
    """
    first = objects[unit.members[0].id]
    members = [objects[member.id] for member in unit.members]
    size_m = unit_size_m(unit)
    kind = _kind(unit, first, is_root=first.id in roots, as_last=_as_last(size_m, last_m))
    node = Node(kind, host=unit.relation.host)
    node.shape = Shape.from_array(unit.array)
    node.ids, node.looks = [each.id for each in members], [looks(each) for each in members]
    halves_m = [foot_m(member.category_id, member.size_m) for member in unit.members]
    _put_place(node, unit, halves_m, objects, site)
    yaw_rad = unit_yaw_rad(unit, objects)
    host_category = "" if unit.host_id is None else objects[unit.host_id].category
    host_box = up_to_level(host_category, _box(unit.host_id, objects))
    around = Surroundings(_box(unit.parent_id, objects), host_box)
    base_m = underside_m(first.bbox)
    node.choices = choices_of(around, size_m, yaw_rad, base_m, is_on_top=kind.is_on_top)
    node.channels[[RISE, 5, 6, 7]] = node.choices[:, 0]
    node.channels[OPENING] = opening_values(first)
    tilt = unit.members[0].tilt_wxyz
    if tilt is not None:
        # Channels keep the tilt about x and y alone.
        rotation = Rotation.from_quat(tilt, scalar_first=True)
        node.channels[TILT] = rotation.as_rotvec()[:2]
    if unit.is_group:
        node.children += _members(unit, members, size_m, base_m, kind)
    return node


def unit_size_m(unit: Unit) -> Vector3:
    """Return the extents of a unit's largest member, axis by axis."""
    x_m, y_m, z_m = np.array([member.size_m for member in unit.members]).max(axis=0).tolist()
    return x_m, y_m, z_m


def _as_last(size_m: Vector3, last_m: Vector3 | None) -> AsLast:
    """Return the name of the extents that equal those of the last unit."""
    if last_m is None:
        return ""
    is_same = [abs(own - last) <= SAME_M for own, last in zip(size_m, last_m, strict=True)]
    return next(name for name, axes in AS_LAST_AXES.items() if all(is_same[i] for i in axes))


def _kind(unit: Unit, obj: SceneObject, *, is_root: bool, as_last: AsLast) -> UnitKind:
    r = unit.relation
    return UnitKind(
        "unit",
        obj.category,
        obj.domain,
        shaping(obj),
        openings(obj),
        relation=r.kind.name,
        side=r.side,
        gap=r.gap.name,
        align=r.align.name,
        slot=r.slot,
        turn=r.quadrant,
        is_turned=abs(unit.residual.yaw_rad) > SAME_RAD,
        as_last=as_last,
        is_group=unit.is_group,
        is_on_top=unit.members[0].is_on_top,
        is_tilted=unit.members[0].tilt_wxyz is not None,
        is_root=is_root,
    )


def _put_place(
    node: Node,
    unit: Unit,
    halves_m: Sequence[Half],
    objects: Mapping[int, SceneObject],
    site: Rectangle,
) -> None:
    """Write the channels of the unit's residual and pitch."""
    relation, residual, array = unit.relation, unit.residual, unit.array
    host = site if unit.host_id is None else footprint(objects[unit.host_id].bbox)
    # Seats go around the table, so their group has no extent of its own.
    half_m = halves_m[0] if relation.kind == RelationKind.SEAT else array_half_m(array, halves_m)
    reach_m = reach_of(relation, residual.yaw_rad, half_m)
    (u0, u1), (v0, v1) = scales(relation, host, reach_m)
    c = node.channels
    c[U], c[V] = (residual.u_m - u0) / u1, (residual.v_m - v0) / v1
    if node.kind.is_turned:
        c[COS], c[SIN] = math.cos(residual.yaw_rad), math.sin(residual.yaw_rad)
    if array is not None:
        extents_m = pitch_base_m(relation.kind, halves_m)
        counts = (array.rows, array.columns)
        c[PITCH] = [
            # A row of one has no pitch.
            pitch_m - extent_m if count > 1 else math.nan
            for pitch_m, extent_m, count in zip(array.pitch_m, extents_m, counts, strict=True)
        ]


def pitch_base_m(kind: RelationKind, halves_m: Sequence[Half]) -> Half:
    """Return the extents of a member beyond which a pitch counts.

    Seats of a table stand side by side, so both directions take their width.
    """
    x_m, y_m = (2 * max(half_m[axis] for half_m in halves_m) for axis in (0, 1))
    return (y_m, y_m) if kind == RelationKind.SEAT else (x_m, y_m)


def unit_yaw_rad(unit: Unit, objects: Mapping[int, SceneObject]) -> float:
    """Return the heading along which sizes are read.

    It is the heading of the first member without its own noise, so that all members of a group
    agree.
    """
    host_rad = 0.0 if unit.host_id is None else objects[unit.host_id].bbox.yaw_rad
    turn = 0 if unit.relation.quadrant == ANY_TURN else unit.relation.quadrant
    return host_rad + (unit.relation.side + turn) * QUARTER + unit.residual.yaw_rad


def _members(
    unit: Unit,
    members: Sequence[SceneObject],
    size_m: Vector3,
    base_m: float,
    kind: UnitKind,
) -> list[Node]:
    """Return a node for each member, or none if all are alike."""
    found: list[Node] = []
    differs = False
    for member, obj in zip(unit.members, members, strict=True):
        node = Node(MemberKind("member", kind.category, kind.domain, relation=kind.relation))
        c, residual = node.channels, member.residual
        # Members state their difference from the first member.
        rise_m = underside_m(obj.bbox) - base_m
        c[[U, V, RISE]] = residual.u_m, residual.v_m, rise_m
        c[COS], c[SIN] = math.cos(residual.yaw_rad), math.sin(residual.yaw_rad)
        c[SIZE] = np.log(member.size_m) - np.log(size_m)
        less_m = np.abs(np.subtract(member.size_m, size_m)).max()
        differs |= max(*map(abs, _numbers(residual)), abs(rise_m), less_m) > SAME_M
        found.append(node)
    return found if differs else []


def _numbers(residual: Residual) -> tuple[float, float, float]:
    return residual.u_m, residual.v_m, residual.yaw_rad


def opening_values(obj: SceneObject) -> list[float]:
    """Return the openings of an object, NaN where it has none; offsets over half its length."""
    values: list[float] = []
    for name in OPENINGS:
        value = obj.attributes.get(name, math.nan)
        value = float(value) if isinstance(value, (int, float)) else math.nan
        values.append(value / (obj.bbox.s[1] / 2) if name.endswith("offset_m") else value)
    return values


def underside_m(box: OrientedBox) -> float:
    """Return the height of the lower face of a box, as if it were upright."""
    return box.p[2] - box.s[2] / 2


def _box(object_id: int | None, objects: Mapping[int, SceneObject]) -> OrientedBox | None:
    return None if object_id is None else objects[object_id].bbox
