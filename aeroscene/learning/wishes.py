"""Wishes that the scene model accepts, and their ranges; loads no PyTorch."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields

from aeroscene.ranges import Range
from aeroscene.scene import Scene, SceneDomain, SceneError

OBJECTS = Range(20, 250)
"""Objects of a scene, coarse and fine together."""
AREAS = Range(1, 200)
"""Landing areas of a scene."""
DENSITY = Range(0.2, 2.0)
"""Factor on the usual number of fine objects."""
CLUTTER = Range(1.0, 10.0)
"""Factor on the usual number of loose objects; 1 adds none."""
PASSAGE_M = Range(0.5, 3.0, "m")
"""Least clear width of doors and corridors."""
OUTLINE_M = Range(15.0, 150.0, "m")
"""Length of a side of a site."""
# A class may be empty, but a scene without any landing area cannot be flown.
_AREAS_OF_CLASS = Range(0, AREAS.high)
_AREAS_OF_CLASSES = Range(AREAS.low, 3 * AREAS.high)


@dataclass(frozen=True, slots=True)
class Wish:
    """Numbers and place that a scene should have, as the networks are conditioned on them."""

    domain: SceneDomain
    n_coarse: int
    n_fine: int
    n_areas: int
    """Landing areas of all sizes."""
    theme: str = ""
    """Theme of the place, such as `waterfront`; empty if it is left open."""

    @staticmethod
    def from_scene(scene: Scene) -> Wish:
        """Return the wish that a scene fulfils exactly."""
        n_coarse = sum(obj.is_coarse for obj in scene.objects)
        n_fine = len(scene.objects) - n_coarse
        return Wish(scene.domain, n_coarse, n_fine, len(scene.landing_areas), scene.theme)


class RequestError(SceneError):
    """A wish that cannot be met; one line with the field, the value and what is valid."""


@dataclass(frozen=True, kw_only=True)
class AreaCounts:
    """Upper bounds of landing areas of each class; the model draws those that are None.

    Raises:
        RequestError: If a count is out of its range, or all three together are.
    """

    small: int | None = None
    medium: int | None = None
    large: int | None = None

    def __post_init__(self) -> None:
        for name, count in self.named.items():
            _AREAS_OF_CLASS.require(f"areas {name}", count, RequestError)
        if len(self.named) == len(fields(self)):
            _AREAS_OF_CLASSES.require("areas in all", sum(self.named.values()), RequestError)

    @property
    def named(self) -> dict[str, int]:
        """Bounds that are set, by the name of their class."""
        return {name: count for name, count in asdict(self).items() if count is not None}
