"""Units as a model draws them: a few symbols and a few numbers each, in drawing order.

Ids are gone: a parent is a row among what stands already (the coarse objects, then the members of
the records before), a host a rank that `aeroscene.relations.hosts` reads.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import count

import numpy as np
from jaxtyping import Bool, Float, Int

from aeroscene.relations.hosts import Standing
from aeroscene.relations.relation import (
    SYMBOLS,
    Align,
    Array,
    Gap,
    Kind,
    Member,
    Relation,
    Residual,
    Unit,
)
from aeroscene.scene import Quaternion, SceneObject

NO_ROW = -1


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Record:
    """One unit; its symbols first, then its numbers, in metres and radians."""

    category_id: int
    parent: int
    """Row of the parent; `NO_ROW` on the bare world."""
    is_group: bool
    fields: Int[np.ndarray, " fields"]
    """Symbols from 0, in the order of `SYMBOLS`; in rows and columns a 0 is one."""
    holes: tuple[int, ...]
    """Places of the array that are empty."""
    turned: tuple[int, ...]
    """Members that look the other way."""
    is_on_top: Bool[np.ndarray, " members"]
    values: Float[np.ndarray, " values"]
    """u, v and heading of the unit, and the pitch of its rows and columns."""
    is_pinned: Bool[np.ndarray, " values"]
    """Which of the values are noise of centimetres; the others are to be drawn."""
    member_values: Float[np.ndarray, "members 4"]
    """u, v, heading and height of each member: all noise, but for the height of what hangs."""
    sizes_m: Float[np.ndarray, "members 3"]
    tilts: tuple[Quaternion | None, ...]


def to_records(units: Iterable[Unit], coarse: Sequence[SceneObject]) -> list[Record]:
    """Units as records.

    Args:
        units: In drawing order.
        coarse: The objects that need no relation, in their order.
    """
    row_of: dict[int | None, int] = {obj.id: row for row, obj in enumerate(coarse)}
    row_of[None] = NO_ROW
    records: list[Record] = []
    for unit in units:
        records.append(_record(unit, row_of[unit.parent_id]))
        for member in unit.members:
            row_of[member.id] = len(row_of) - 1
    return records


def _record(unit: Unit, parent: int) -> Record:
    relation, residual, array = unit.relation, unit.residual, unit.array or Array()
    symbols = [int(getattr(relation, name)) for name in tuple(SYMBOLS)[:-2]]
    members = [(m.residual.u_m, m.residual.v_m, m.residual.yaw_rad, m.rise_m) for m in unit.members]
    return Record(
        category_id=unit.members[0].category_id,
        parent=parent,
        is_group=unit.is_group,
        fields=np.array([*symbols, array.rows - 1, array.columns - 1]),
        holes=array.holes,
        turned=array.turned,
        is_on_top=np.array([member.is_on_top for member in unit.members]),
        values=np.array([residual.u_m, residual.v_m, residual.yaw_rad, *array.pitch_m]),
        is_pinned=np.array([*relation.pinned, False, False]),
        member_values=np.array(members),
        sizes_m=np.array([member.size_m for member in unit.members]),
        tilts=tuple(member.tilt_wxyz for member in unit.members),
    )


def to_units(
    records: Iterable[Record], coarse: Sequence[SceneObject], ids: Iterator[int] | None = None
) -> tuple[Unit, ...]:
    """Units of records, exactly those that `to_records` has read.

    Args:
        records: In drawing order.
        coarse: The objects that need no relation, in their order.
        ids: For the members in turn; by default those after the greatest coarse one.

    Raises:
        IndexError: If a record refers to a host that does not stand.
    """
    ids = ids or count(max((obj.id for obj in coarse), default=-1) + 1)
    standing, row_ids = Standing(tuple(coarse)), [obj.id for obj in coarse]
    units: list[Unit] = []
    for record in records:
        parent_id = None if record.parent == NO_ROW else row_ids[record.parent]
        unit = _unit(record, parent_id, standing, ids)
        table = unit.host_id if unit.relation.kind == Kind.SEAT else None
        for member in unit.members:
            standing.add(member.id, member.category_id, parent_id, table)
            row_ids.append(member.id)
        units.append(unit)
    return tuple(units)


def _unit(record: Record, parent_id: int | None, standing: Standing, ids: Iterator[int]) -> Unit:
    kind, host, side, gap, align, slot, quadrant, rows, columns = record.fields.tolist()
    relation = Relation(
        kind=Kind(kind),
        host=host,
        side=side,
        gap=Gap(gap),
        align=Align(align),
        slot=slot,
        quadrant=quadrant,
    )
    hosts = standing.possible_hosts(relation.kind, record.category_id, parent_id)
    u_m, v_m, yaw_rad, *pitch_m = record.values.tolist()
    array = Array(
        rows=rows + 1,
        columns=columns + 1,
        pitch_m=(pitch_m[0], pitch_m[1]),
        holes=record.holes,
        turned=record.turned,
    )
    return Unit(
        parent_id=parent_id,
        host_id=hosts[host],
        relation=relation,
        members=tuple(_member(record, index, next(ids)) for index in range(len(record.sizes_m))),
        array=array if record.is_group else None,
        residual=Residual(u_m, v_m, yaw_rad),
    )


def _member(record: Record, index: int, object_id: int) -> Member:
    u_m, v_m, yaw_rad, rise_m = record.member_values[index].tolist()
    x_m, y_m, z_m = record.sizes_m[index].tolist()
    return Member(
        id=object_id,
        category_id=record.category_id,
        size_m=(x_m, y_m, z_m),
        is_on_top=bool(record.is_on_top[index]),
        rise_m=rise_m,
        tilt_wxyz=record.tilts[index],
        residual=Residual(u_m, v_m, yaw_rad),
    )
