"""Greatest numbers of landing areas of a scene, by class."""

from __future__ import annotations

from dataclasses import replace

from aeroscene.areas.needs import AreaLimits
from aeroscene.corpus.curation.curate import Budget
from aeroscene.learning.wishes import AreaCounts

_MORE_SMALL, _MORE_LARGE = 2, 1
"""Small and large areas beyond those of the corpus. Generated scenes cannot always offer as many,
because indoor ones have less floor. With these, averages are within 5% of the paper's."""


def area_limits(n_areas: int | AreaCounts | None, budget: Budget) -> AreaLimits:
    """Return the greatest number of areas of each class.

    Args:
        n_areas: Wish of the user. A number is split in the proportions of the budget; counts of
            classes replace the budget's; None takes the budget's.
        budget: Budget of the corpus for this seed.
    """
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
    # Small areas take the rounding errors, so that the sum is exactly as wished for.
    return AreaLimits(
        small=n_areas - medium - large,
        medium=medium,
        large=large,
        perching=round(share * drawn.perching),
    )


def in_all(limits: AreaLimits) -> int:
    """Sum of the landing areas of all classes; perching areas do not count."""
    return limits.small + limits.medium + limits.large
