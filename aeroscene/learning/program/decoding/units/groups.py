"""Groups that move together to find room: chairs with their table, shelves back to back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from aeroscene.learning.program.decoding.draft import Draft
from aeroscene.learning.program.decoding.draft.neighbours import free_of, free_shift, moved
from aeroscene.learning.program.decoding.draft.supports import is_on_any
from aeroscene.learning.program.decoding.units.reading import member_boxes
from aeroscene.relations import Unit
from aeroscene.relations.relation import N_SIDES, Gap, Kind
from aeroscene.scene import OrientedBox

_BEHIND = 2
"""Side of a host, and quarter turns of a heading away from it."""
_SAME_PITCH_M = 0.6
"""Pitches that differ by less are meant to be equal; greater differences are on purpose."""


def moved_with(
    draft: Draft, boxes: Sequence[OrientedBox], others: Sequence[int], n_given: int
) -> list[OrientedBox] | None:
    """Return boxes where they have room after other objects have moved with them.

    Args:
        draft: Objects so far; the others are moved in it.
        boxes: Boxes that come.
        others: Ids of the objects that move along, all on the same bearer.
        n_given: Number of given objects, which do not move.

    Returns:
        None if there is no room, or an object is given. Nothing has moved then.
    """
    # Given objects have the lowest ids.
    if min(others) < n_given:
        return None
    bearer = draft.standing.bearer(others[0])
    own = [draft.objects[number].bbox for number in others]
    within = draft.extent(bearer)
    taken = draft.taken(bearer, without=others)
    shift = free_shift([*own, *boxes], taken, within, ways_rad=None)
    if shift is None or not draft.is_borne(bearer, [moved(box, shift) for box in [*own, *boxes]]):
        return None
    for number, box in zip(others, own, strict=True):
        draft.move(number, moved(box, shift))
    return [moved(box, shift) for box in boxes]


def drawn_up(
    draft: Draft, chairs: Sequence[OrientedBox], table: int, n_given: int
) -> list[OrientedBox]:
    """Return the chairs that have room, after their table has moved with them if that helps.

    Args:
        draft: Objects so far; the table may be moved in it.
        chairs: Boxes of the chairs.
        table: Id of their table.
        n_given: Number of given objects, which do not move.
    """
    boxes = moved_with(draft, chairs, [table], n_given)
    if boxes is not None:
        return boxes
    return free_of(draft.taken(draft.standing.bearer(table), without=[table]), chairs)


def backed_by(draft: Draft, unit: Unit) -> list[int]:
    """Return the group to which a unit of the same kind stands back to back; empty for others."""
    relation, host = unit.relation, unit.host_id
    if host is None or relation.kind != Kind.SIDE:
        return []
    is_behind = relation.gap == Gap.TOUCH and relation.side == _BEHIND
    is_turned_away = (relation.side + relation.quadrant) % N_SIDES == _BEHIND
    is_alike = draft.objects[host].category_id == unit.members[0].category_id
    return draft.group_of(host) if is_behind and is_turned_away and is_alike else []


def back_to_back(
    draft: Draft, unit: Unit, others: Sequence[int], n_given: int
) -> list[OrientedBox] | None:
    """Return the boxes of a unit at the backs of others, which move with it; None without room.

    The pitch of a group is that of the other one if it is about the same. Members outside of a room
    that is too small for both are left out.
    """
    drawn = member_boxes(_as_even_as(unit, draft.pitch_m(others[0])), draft.box)
    # Both groups move as one, so an overlap between them would stay.
    if len(free_of(draft.neighbours.rows(others), drawn)) < len(drawn):
        return None
    boxes = moved_with(draft, drawn, others, n_given)
    if boxes is None or unit.parent_id is None:
        return boxes
    tiles = draft.tiles(unit.parent_id)
    return [box for box in boxes if is_on_any(box, tiles)] or None


def _as_even_as(unit: Unit, pitch_m: tuple[float, float] | None) -> Unit:
    """Return a unit whose array takes a pitch if its own is about the same."""
    array = unit.array
    if array is None or pitch_m is None:
        return unit
    is_meant = np.allclose(pitch_m, array.pitch_m, rtol=0, atol=_SAME_PITCH_M)
    return replace(unit, array=replace(array, pitch_m=pitch_m)) if is_meant else unit
