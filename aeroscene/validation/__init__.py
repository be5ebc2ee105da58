"""Validation of a scene: typed findings, each with the figures that break the rule.

Claims are checked against geometry, not against the code that made them, so that a fault in that
code shows.
"""

from __future__ import annotations

from collections.abc import Sequence

from aeroscene.scene import Scene
from aeroscene.solids.freespace import VoxelField
from aeroscene.solids.shapes import Primitive, scene_primitives
from aeroscene.solids.solids import colliding
from aeroscene.validation.access import unreachable
from aeroscene.validation.boxes import outside, overlaps
from aeroscene.validation.claims import unlandable
from aeroscene.validation.findings import Finding, FindingKind
from aeroscene.validation.support import floating

__all__ = ["Finding", "FindingKind", "validate"]


def validate(
    scene: Scene, primitives: Sequence[Primitive] | None = None, field: VoxelField | None = None
) -> tuple[Finding, ...]:
    """Find everything that is wrong with a scene; a sound scene has no findings.

    `overlap`: boxes that share an IoU above 0.01 although neither belongs to the other. `floating`:
    objects without support below their feet. `outside`: boxes beyond the flight volume.
    `unreachable`: a start or an area without a free path to it. `unlandable`: areas whose slope,
    surface, radius, room or clearance differs from their claim.

    Args:
        scene: Scene.
        primitives: Its primitives, if the caller has them already.
        field: Its distance field, likewise; capped no lower than `FIELD_CAP_M`.
    """
    primitives = scene_primitives(scene) if primitives is None else primitives
    solids = colliding(primitives)
    return (
        *overlaps(scene),
        *floating(scene, solids),
        *outside(scene),
        *unreachable(scene, primitives, field),
        *unlandable(scene, solids),
    )
