"""Landing areas that are asked for, by their sizes."""

from __future__ import annotations

from dataclasses import replace

from aeroscene.areas.needs import AreaLimits
from aeroscene.corpus.curation.curate import Budget
from aeroscene.learning.wishes import AreaCounts

_MORE_SMALL, _MORE_LARGE = 2, 1
"""Areas asked for beyond those of the corpus: generated scenes, of which the indoor ones have less
floor, cannot always offer as many. With it averages are within 5% of the paper's."""


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
