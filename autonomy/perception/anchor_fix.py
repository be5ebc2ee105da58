"""Result of one depth image for the offset between estimate and map."""

from __future__ import annotations

from dataclasses import dataclass

from autonomy.perception.level_fix import LevelFix
from autonomy.types import Vector3


@dataclass(frozen=True, kw_only=True, eq=False)
class AnchorFix:
    """Result of one depth image that `MapAnchor.update` has registered."""

    accepted: bool
    """True if the image was fused."""
    reason: str
    """Reason for the refusal, or the number of directions that the image determined, in a few
    words."""
    offset_enu_m: Vector3
    """Offset from the estimate to the map, by this image and all earlier ones."""
    yaw_rad: float
    """Yaw from the estimate to the map, by the same images."""
    residual_m: float
    """Mean distance of the explained points from the map's surfaces."""
    inlier_share: float
    """Share of the points that the map explains."""
    sigma_m: float
    """Standard deviation of the offset, the worst horizontal direction."""
    level: LevelFix | None = None
    """Horizontal offset by this image alone; None if it was refused or leaves a direction open."""
