"""Places from relations, and residuals from places: exact in both directions.

    place of a unit    = relation's place + residual (u, v, yaw), in the frame of the host's side
    place of a member  = cell of the unit's array + residual

With all residuals `place` gives back the boxes that `scene_relations` has read. Without those of
pinned axes it gives the scene that the relations alone describe.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

from aeroscene.relations.plane import (
    QUARTER,
    WORLD,
    Half,
    Place,
    Rectangle,
    footprint,
    turned_reach_m,
)
from aeroscene.relations.relation import (
    ANY_TURN,
    GAPS_M,
    LANES,
    OUTSIDE,
    SEAT_GAPS_M,
    Align,
    Array,
    Gap,
    Kind,
    Member,
    Relation,
    Residual,
    Unit,
)
from aeroscene.scene.box import OrientedBox, Vector3, quat_from_yaw, quat_product
from aeroscene.scene.catalogue import CATALOGUE, POSTS


def locate(relation: Relation, residual: Residual, host: Rectangle, half_m: Half) -> Place:
    """Return the place of a footprint that stands in a relation.

    Args:
        relation: Its relation.
        residual: Its deviation from the relation's own place.
        host: Footprint of the host.
        half_m: Half extents of the footprint.
    """
    turn_rad = residual.yaw_rad
    if relation.quadrant != ANY_TURN:
        turn_rad += relation.quadrant * QUARTER
    u_m, v_m = _anchor(relation, host, turned_reach_m(half_m, turn_rad))
    frame = host.from_side(relation.side)
    return frame.moved(u_m + residual.u_m, v_m + residual.v_m, turn_rad)


def residual_of(relation: Relation, host: Rectangle, child: Rectangle) -> Residual:
    """Return the residual with which `locate` gives back a place.

    Args:
        relation: Relation of the object.
        host: Footprint of the host.
        child: Footprint of the object.
    """
    u_m, v_m, turn_rad = host.from_side(relation.side).local(child.place)
    at_u_m, at_v_m = _anchor(relation, host, turned_reach_m(child.half_m, turn_rad))
    if relation.quadrant != ANY_TURN:
        turn_rad = math.remainder(turn_rad - relation.quadrant * QUARTER, 2.0 * math.pi)
    return Residual(u_m - at_u_m, v_m - at_v_m, turn_rad)


def _anchor(relation: Relation, host: Rectangle, reach_m: Half) -> tuple[float, float]:
    """Return the middle that a relation alone gives a footprint with some reach along u and v."""
    host_u_m, host_v_m = host.reach_m(relation.side)
    is_outside = relation.kind in OUTSIDE
    gap_m = gap_middle_m(relation)
    # A free axis counts from the host's middle.
    u_m = 0.0
    if relation.gap < Gap.MIDDLE:
        u_m = host_u_m + (gap_m + reach_m[0] if is_outside else -gap_m - reach_m[0])
    v_m = 0.0
    if relation.align in {Align.LOW, Align.HIGH}:
        v_m = host_v_m - reach_m[1] - (0.0 if is_outside else gap_m or GAPS_M[Gap.TOUCH])
        # LOW is the end with negative v.
        v_m = -v_m if relation.align == Align.LOW else v_m
    elif relation.kind == Kind.LANE:
        v_m = 2.0 * host_v_m * LANES[relation.slot]
    return u_m, v_m


def gap_middle_m(relation: Relation) -> float:
    """Return the middle of a relation's class of gaps; 0 if it has none."""
    if relation.gap >= Gap.MIDDLE:
        return 0.0
    return (SEAT_GAPS_M if relation.kind == Kind.SEAT else GAPS_M)[relation.gap]


def array_half_m(array: Array | None, halves_m: Sequence[Half]) -> Half:
    """Return the half extents of a group of footprints, or of a single one.

    Args:
        array: Array of the group; None for a single object.
        halves_m: Half extents of the members.
    """
    x_m, y_m = (max(half_m[axis] for half_m in halves_m) for axis in (0, 1))
    if array is None:
        return x_m, y_m
    (pitch_x_m, pitch_y_m) = array.pitch_m
    return x_m + (array.rows - 1) * pitch_x_m / 2, y_m + (array.columns - 1) * pitch_y_m / 2


def foot_m(category_id: int, size_m: Vector3) -> Half:
    """Return the half extents of an object's footprint; of a lamp post without its arm.

    The arm of a lamp post reaches over the road, so its middle would not be where the post stands.
    """
    x_m, y_m = size_m[0] / 2, size_m[1] / 2
    if CATALOGUE[category_id].name in POSTS:
        return min(x_m, y_m), min(x_m, y_m)
    return x_m, y_m


def cell_places(unit: Unit, host: Rectangle) -> list[Place]:
    """Return the place of each member, without its own residual.

    Args:
        unit: The unit.
        host: Footprint of its host.
    """
    relation, array, residual = unit.relation, unit.array, unit.residual
    halves_m = [foot_m(member.category_id, member.size_m) for member in unit.members]
    if array is None:
        return [locate(relation, residual, host, halves_m[0])]
    if relation.kind == Kind.SEAT:
        cells = zip(array.cells(Kind.SEAT), halves_m, strict=True)
        return [_seat(unit, host, cell, half_m) for cell, half_m in cells]
    middle = locate(relation, residual, host, array_half_m(array, halves_m))
    return [
        middle.moved(
            (row - (array.rows - 1) / 2) * array.pitch_m[0],
            (column - (array.columns - 1) / 2) * array.pitch_m[1],
            # Turned members look the other way: cars that were parked backwards.
            math.pi if index in array.turned else 0.0,
        )
        for index, (row, column) in enumerate(array.cells(relation.kind))
    ]


def _seat(unit: Unit, host: Rectangle, cell: tuple[int, int], half_m: Half) -> Place:
    """Return the place of a chair: all chairs share one gap, and seats are evenly spaced."""
    (side, seat), array = cell, unit.array
    assert array is not None
    count, pitch_m = ((array.rows, array.columns)[side % 2], array.pitch_m[side % 2])
    relation = Relation(kind=Kind.SEAT, side=side, gap=unit.relation.gap, quadrant=2)
    along_m = (seat - (count - 1) / 2) * pitch_m
    return locate(relation, Residual(unit.residual.u_m, along_m), host, half_m)


def place(units: Iterable[Unit], hosts: Mapping[int, OrientedBox]) -> dict[int, OrientedBox]:
    """Build the boxes of units, in drawing order.

    Args:
        units: As `scene_relations` gives them; the host of each is given or comes before it.
        hosts: Boxes under their ids, the coarse ones of a scene.

    Returns:
        Boxes of the members under their ids.
    """
    boxes = dict(hosts)
    found: dict[int, OrientedBox] = {}
    for unit in units:
        host = WORLD if unit.host_id is None else footprint(boxes[unit.host_id])
        parent = None if unit.parent_id is None else boxes[unit.parent_id]
        for member, cell in zip(unit.members, cell_places(unit, host), strict=True):
            residual = member.residual
            spot = cell.moved(residual.u_m, residual.v_m, residual.yaw_rad)
            box = _box(member, spot, parent)
            boxes[member.id] = found[member.id] = box
    return found


def _box(member: Member, spot: Place, parent: OrientedBox | None) -> OrientedBox:
    low_m, top_m = levels_m(parent)
    base_m = (top_m if member.is_on_top else low_m) + member.rise_m
    quat = quat_from_yaw(spot.yaw_rad)
    if member.tilt_wxyz is not None:
        # The tilt is applied in the object's own axes, the heading after it.
        w, x, y, z = quat_product(quat, member.tilt_wxyz)
        quat = (w, x, y, z)
    return OrientedBox((spot.x_m, spot.y_m, base_m + member.size_m[2] / 2), quat, member.size_m)


def levels_m(box: OrientedBox | None) -> tuple[float, float]:
    """Return the heights of a box's underside and top, as if it were upright; 0 for the ground."""
    if box is None:
        return 0.0, 0.0
    return box.p[2] - box.s[2] / 2, box.p[2] + box.s[2] / 2
