"""What may be asked of the scene model, and within which ranges; loads no PyTorch."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields

from aeroscene.ranges import Range
from aeroscene.scene import Scene, SceneDomain, SceneError

OBJECTS = Range(20, 250)
AREAS = Range(1, 200)
DENSITY = Range(0.2, 2.0)
CLUTTER = Range(1.0, 10.0)
PASSAGE_M = Range(0.5, 3.0, "m")
"""Least clear width of doors and corridors."""
OUTLINE_M = Range(15.0, 150.0, "m")
"""A side of a site."""
_AREAS_OF_CLASS = Range(0, AREAS.high)
_AREAS_OF_CLASSES = Range(AREAS.low, 3 * AREAS.high)


@dataclass(frozen=True, slots=True)
class Wish:
    """Demands on the content of a scene."""

    domain: SceneDomain
    n_coarse: int
    n_fine: int
    n_areas: int
    """Landing areas of all sizes."""
    theme: str = ""
    """What the place is, empty where nobody has said it."""

    @staticmethod
    def of(scene: Scene) -> Wish:
        """Wish that a scene fulfils."""
        n_coarse = sum(obj.is_coarse for obj in scene.objects)
        n_fine = len(scene.objects) - n_coarse
        return Wish(scene.domain, n_coarse, n_fine, len(scene.landing_areas), scene.theme)


class RequestError(SceneError):
    """A wish that cannot be met; one line with the field, the value and what is valid."""


@dataclass(frozen=True, kw_only=True)
class AreaCounts:
    """Landing areas of each class, at most; what is None is drawn."""

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
        """Counts that are not left open."""
        return {name: count for name, count in asdict(self).items() if count is not None}
