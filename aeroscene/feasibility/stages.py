"""The stages of a projection, and their order.

Coarse objects come before fine ones, because fine ones move with them. Heights come before the
plane, because they decide which boxes can meet at all, and again after every stage that moves
objects to other ground.
"""

from __future__ import annotations

from dataclasses import replace
from math import atan2

import numpy as np
from jaxtyping import Bool, Int

from aeroscene.feasibility.boxes import Boxes, joined, strangers
from aeroscene.feasibility.doors import door_air, fit_openings, yield_to_furniture
from aeroscene.feasibility.extents import fit_extent, hold_all
from aeroscene.feasibility.gaps import settle_gaps
from aeroscene.feasibility.ground import find_ground
from aeroscene.feasibility.headings import square_up
from aeroscene.feasibility.heights import set_heights
from aeroscene.feasibility.home import home_air, home_row, settle_home, start_air
from aeroscene.feasibility.hosts import rehome
from aeroscene.feasibility.layout import Layout
from aeroscene.feasibility.overlap_repair import (
    cut_overlaps,
    give_up,
    resettle,
    set_on_earth,
    settle,
)
from aeroscene.feasibility.partitions import merge_walls
from aeroscene.feasibility.plane import PlaneProblem
from aeroscene.feasibility.roles import is_chained
from aeroscene.feasibility.seats import turns_to_tables
from aeroscene.feasibility.shells import fit_shells, lay_roofs
from aeroscene.feasibility.stairs import drop_lost, follow_levels, landings_of
from aeroscene.feasibility.strays import drop_strays
from aeroscene.feasibility.tiling import fill_buildings, hold_children, make_room
from aeroscene.feasibility.traffic import turns_with_traffic
from aeroscene.scene import Scene
from aeroscene.scene.catalogue import GROUND
from aeroscene.scene.rooms import strayed_to
from aeroscene.solids.shapes import scene_primitives
from aeroscene.solids.solids import colliding
from aeroscene.validation.boxes import overlaps
from aeroscene.validation.support import floating


def project(layout: Layout) -> None:
    """Run all stages of a projection in their order; the layout is changed."""
    _support(layout)
    landings = landings_of(layout)
    _part_ground(layout)
    _part_coarse(layout)
    follow_levels(layout, landings)
    _part_fine(layout)
    _clear_up(layout)
    drop_lost(layout, landings)
    drop_strays(layout)


def project_beside(layout: Layout) -> None:
    """Find room beside pinned objects for all others; those without room are dropped.

    Args:
        layout: Layout with pinned objects; changed.
    """
    find_ground(layout)
    set_heights(layout, _downwards(layout))
    PlaneProblem(layout, _leave_home(layout), _air(layout)).solve()
    _settle_fine(layout)
    hold_all(layout)
    _drop_overlapping(layout)


def _support(layout: Layout) -> None:
    """Set headings and heights, which decide which objects can meet at all."""
    find_ground(layout)
    square_up(layout)
    fit_shells(layout)
    merge_walls(layout)
    fit_extent(layout)
    set_heights(layout, _downwards(layout))


def _part_ground(layout: Layout) -> None:
    """Part covers and land from each other; then everything stands on the ground below it."""
    boxes = layout.boxes
    is_ground = np.array(
        [
            obj.category in GROUND and (boxes.parent[i] < 0 or _is_chained(layout, i))
            for i, obj in enumerate(layout.objects)
        ],
        dtype=bool,
    )
    # Cuts may open other conflicts, hence twice.
    for _ in range(2):
        PlaneProblem(layout, is_ground, among=is_ground).solve()
        if not cut_overlaps(layout, is_ground):
            break
    hold_children(layout)
    rehome(layout)
    find_ground(layout)
    set_heights(layout, _downwards(layout))


def _is_chained(layout: Layout, row: int) -> bool:
    parent = layout.parent_of(row)
    return parent is not None and is_chained(layout.objects[row], parent)


def _part_coarse(layout: Layout) -> None:
    is_coarse = layout.is_coarse
    if layout.is_house.any():
        # Cut first, or walls would make room for the lawn too.
        is_ground = np.array([obj.category in GROUND for obj in layout.objects], dtype=bool)
        cut_overlaps(layout, layout.is_house | is_ground, is_whole=layout.is_house)
    for _ in range(2):
        PlaneProblem(layout, is_coarse, among=is_coarse).solve()
        if not cut_overlaps(layout, is_coarse):
            break
    # Moved objects may overlap surfaces that can be cut; what overlaps after that is moved again.
    resettle(layout, is_coarse, _nothing())
    cut_overlaps(layout, is_coarse)
    resettle(layout, is_coarse, _nothing())
    hold_children(layout)
    fill_buildings(layout)
    rehome(layout)
    set_heights(layout, _downwards(layout))


def _part_fine(layout: Layout) -> None:
    fit_openings(layout)
    yield_to_furniture(layout)
    is_fine = _leave_home(layout)
    air = _air(layout)
    make_room(layout, is_fine, air)
    PlaneProblem(layout, is_fine, air).solve()
    resettle(layout, is_fine, air)
    set_heights(layout, _downwards(layout))


def _leave_home(layout: Layout) -> Bool[np.ndarray, " n"]:
    """Settle the pad of the start; return the fine objects that make room for it."""
    is_fine, row = layout.is_fine, home_row(layout)
    if row is not None and is_fine[row]:
        settle_home(layout, row)
        is_fine[row] = False
    return is_fine


def _air(layout: Layout) -> Boxes:
    """Boxes of air that fine objects leave free: before doors, and about the home pad.

    If objects are pinned and there is no pad, the flight starts where it did.
    """
    doors, row = door_air(layout), home_row(layout)
    if row is not None:
        return joined(home_air(layout, row), doors)
    return joined(start_air(layout), doors) if layout.is_pinned.any() else doors


def _clear_up(layout: Layout) -> None:
    """Fit roofs and openings; set down or drop objects that still overlap or float."""
    lay_roofs(layout)
    fit_openings(layout)
    fit_extent(layout)
    is_coarse = layout.is_coarse
    resettle(layout, is_coarse, _nothing())
    _settle_fine(layout)
    hold_all(layout)
    _drop_overlapping(layout)


def _settle_fine(layout: Layout) -> None:
    """Settle fine objects where they have room, upright and supported."""
    resettle(layout, layout.is_fine, _air(layout))
    # A turned chair or vehicle may overlap again, hence once more after turning.
    _turn_about(layout)
    resettle(layout, layout.is_fine, _air(layout))
    # Before floating objects are looked for, because a shift may take one off its bearer.
    settle_gaps(layout, _air(layout))
    _mend_floating(layout)
    _turn_about(layout)


def _drop_overlapping(layout: Layout) -> None:
    """Drop objects that share too much with their ancestors, which may overlap them otherwise."""
    rows: dict[int | None, int] = {obj.id: row for row, obj in enumerate(layout.objects)}
    for finding in tuple(overlaps(finished(layout))):
        row = rows.get(finding.object_id)
        if row is not None and not layout.is_pinned[row]:
            layout.drop(row)


def _turn_about(layout: Layout) -> None:
    """Turn chairs to their present table, and vehicles into the direction of their lane."""
    known = layout.objects, layout.boxes, layout.is_present
    for row, turn_rad in [*turns_to_tables(*known), *turns_with_traffic(*known)]:
        if not layout.is_pinned[row]:
            layout.turn(row, turn_rad)


def _mend_floating(layout: Layout) -> None:
    """Set down objects that stand on nothing: on their host, else on the earth, else drop them.

    Their host is tried twice: a room that is dropped leaves its objects to the next one.
    """
    for mend in (settle, settle, set_on_earth, give_up):
        rows = _floating(layout)
        if not rows:
            return
        for row in rows:
            mend(layout, row, _nothing())
        set_heights(layout, _downwards(layout))
        resettle(layout, layout.is_fine, _air(layout))
    for row in _floating(layout):
        layout.drop(row)


def _floating(layout: Layout) -> list[int]:
    scene = finished(layout)
    row = {obj.id: i for i, obj in enumerate(layout.objects)}
    solids = colliding(scene_primitives(scene))
    found = [row[f.object_id] for f in floating(scene, solids) if f.object_id is not None]
    return [each for each in found if not layout.is_pinned[each]]


def _downwards(layout: Layout) -> Int[np.ndarray, " n"]:
    """All rows, each after the object that carries it, and a chair after its table."""
    depth = np.array([len(layout.chain(i)) for i in range(len(layout.host))])
    # By generations; a chair has the same depth as its table.
    return np.lexsort((layout.table >= 0, depth))


def _nothing() -> Boxes:
    return strangers(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))


def finished(layout: Layout) -> Scene:
    """The scene in its present state: its start on its pad, its sky above the highest object."""
    scene, boxes = layout.scene, layout.boxes
    parents = [None if row < 0 else row for row in boxes.parent.tolist()]
    whole = [layout.box(row) for row in range(len(boxes))]
    for row, tile in strayed_to(layout.tile_group, parents, whole).items():
        if layout.is_present[tile]:
            boxes.parent[row] = tile
    low, high = layout.extent_m.tolist()
    start, yaw = tuple(np.clip(scene.start_position_enu_m, low, high).tolist()), scene.start_yaw_rad
    row = home_row(layout)
    if row is not None:
        u, v = (round(value, 4) for value in boxes.centre_m[row, :2].tolist())
        start = (u, v, round(float(boxes.top_m[row]), 4))
        # The vehicle looks towards the middle of the site, as in curation.
        yaw = round(atan2(-v, -u), 6)
    return replace(
        scene,
        objects=layout.remaining(),
        interaction_areas=(),
        extent_min_enu_m=tuple(low),
        extent_max_enu_m=tuple(high),
        start_position_enu_m=start,
        start_yaw_rad=yaw,
    )
