"""Access to the start and to every area, by floods of free space."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from aeroscene.areas.needs import area_needs
from aeroscene.areas.reachability import access_field
from aeroscene.scene import Scene
from aeroscene.solids.freespace import NoFreeSpaceError, VoxelField, reachable
from aeroscene.solids.shapes import Primitive
from aeroscene.validation.findings import Finding

SMALLEST_BALL_M = 0.45
"""Radius of a ball that must be able to leave the start."""


def unreachable(
    scene: Scene, primitives: Sequence[Primitive], field: VoxelField | None = None
) -> Iterator[Finding]:
    """Find a start that nothing can leave, and areas that no drone of their class can reach.

    Args:
        scene: Scene.
        primitives: Its primitives.
        field: Its distance field, if the caller has it already.
    """
    # One flood for each radius, since a flood takes longer than all tests of areas.
    radii = {SMALLEST_BALL_M, *(area_needs(a).flight_radius_m for a in scene.interaction_areas)}
    if field is None:
        field = access_field(scene, primitives)
    for radius_m in sorted(radii):
        try:
            reached = reachable(field, scene.start_position_enu_m, radius_m)
        except NoFreeSpaceError as error:
            yield Finding(kind="unreachable", scene_id=scene.scene_id, detail=str(error))
            continue
        for area in scene.interaction_areas:
            needs, cell = area_needs(area), field.cell(area.centroid)
            # Each flood serves the areas whose drones have its radius.
            if needs.flight_radius_m != radius_m:
                continue
            if cell is None or not needs.is_entered(reached, cell, field.resolution_m):
                rise_m = needs.rise_m(field.resolution_m)
                yield Finding(
                    kind="unreachable",
                    scene_id=scene.scene_id,
                    object_id=area.object_id,
                    area_id=area.id,
                    detail=f"{area.kind} area {area.id} for {area.drone_class} drones: no free way "
                    f"for a ball of {radius_m} m from the start to the {rise_m:.2f} m above it",
                )
