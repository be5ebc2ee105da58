"""What may be asked for, and within which limits."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields, replace

from aeroscene.areas.needs import AreaLimits
from aeroscene.corpus.curation.curate import Budget
from aeroscene.scene import SceneError

OBJECTS = (20, 250)
"""Fewest and most objects that may be asked for."""
AREAS = (1, 200)
DENSITY = (0.2, 2.0)
CLUTTER = (1.0, 10.0)
PASSAGE_M = (0.5, 3.0)
"""Least and greatest width of doors and corridors that may be asked for."""
OUTLINE_M = (15.0, 150.0)
"""Shortest and longest side of a site."""
_MORE_SMALL, _MORE_LARGE = 2, 1
"""Areas asked for beyond those of the corpus: generated scenes, of which the indoor ones have less
floor, cannot always offer as many. With it averages are within 5% of the paper's."""


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
            require_within(f"areas {name}", count, 0, AREAS[1])
        if len(self.named) == len(fields(self)):
            require_within("areas in all", sum(self.named.values()), AREAS[0], 3 * AREAS[1])

    @property
    def named(self) -> dict[str, int]:
        """Counts that are not left open."""
        return {name: count for name, count in asdict(self).items() if count is not None}


def area_limits(n_areas: int | AreaCounts | None, budget: Budget) -> AreaLimits:
    """Areas by size that are asked for, in the proportions of the budget."""
    drawn = replace(
        budget.areas,
        small=budget.areas.small + _MORE_SMALL,
        large=budget.areas.large + _MORE_LARGE,
    )
    if n_areas is None:
        return drawn
    if isinstance(n_areas, AreaCounts):
        return replace(drawn, **n_areas.named)
    share = n_areas / (drawn.small + drawn.medium + drawn.large)
    medium, large = round(share * drawn.medium), round(share * drawn.large)
    return AreaLimits(
        small=n_areas - medium - large,
        medium=medium,
        large=large,
        perching=round(share * drawn.perching),
    )


def in_all(limits: AreaLimits) -> int:
    """Landing areas of all classes."""
    return limits.small + limits.medium + limits.large


def require_within(name: str, value: float, low: float, high: float) -> None:
    """Refuse a number out of its range."""
    if not low <= value <= high:
        raise RequestError(f"{name} is {value}, valid: {low:g} to {high:g}")
