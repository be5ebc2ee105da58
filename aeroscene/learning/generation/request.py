"""Request of a user for a scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from aeroscene.areas.needs import AreaLimits
from aeroscene.corpus.curation.curate import Budget, draw_budget
from aeroscene.learning.tokens.kinds import DOMAINS
from aeroscene.learning.tokens.skeleton import Wish
from aeroscene.scene import Scene, SceneDomain, SceneError

OBJECTS = (20, 250)
"""Fewest and most objects that may be asked for."""
AREAS = (1, 200)
OUTLINE_M = (15.0, 150.0)
"""Shortest and longest side of a site."""
_MORE_COARSE, _MORE_FINE = 2, 4
"""Asked for beyond the budget of the corpus, whose structures bring some objects of their own."""
_MORE_SMALL, _MORE_LARGE = 2, 1
"""Areas asked for beyond those of the corpus: generated scenes, of which the indoor ones have less
floor, cannot always offer as many. With it averages are within 5% of the paper's."""


class RequestError(SceneError):
    """A wish that cannot be met; one line with the field, the value and what is valid."""


@dataclass(frozen=True, kw_only=True)
class Request:
    """A scene to be generated; what is None is drawn from the seed."""

    seed: int
    """Same seed, same device, same checkpoint: same scene."""
    domain: SceneDomain | None = None
    n_objects: int | None = None
    """About so many, coarse and fine."""
    n_areas: int | None = None
    """Landing areas, at most."""
    outline_m: tuple[float, float] | None = None
    """Sides of the site along x and y, m."""
    complete: Scene | None = None
    """A scene whose coarse objects stay as they are; fine ones are made for them."""

    def __post_init__(self) -> None:
        _check("seed", self.seed, 0, 2**63 - 1)
        if self.n_objects is not None:
            _check("objects", self.n_objects, *OBJECTS)
        if self.n_areas is not None:
            _check("areas", self.n_areas, *AREAS)
        for side in self.outline_m or ():
            _check("outline", side, *OUTLINE_M)
        if self.complete is not None and self.outline_m is not None:
            raise RequestError(
                f"outline is {self.outline_m} beside a scene to complete, valid: one of the two; "
                "the scene has an outline of its own"
            )

    @property
    def kept(self) -> Scene | None:
        """The coarse part of the scene that is to be completed."""
        if self.complete is None:
            return None
        coarse = tuple(obj for obj in self.complete.objects if obj.is_coarse)
        return replace(self.complete, objects=coarse, interaction_areas=())

    def drawn(
        self, rng: np.random.Generator, seen: Sequence[Wish] = (), *, is_corpus: bool = False
    ) -> tuple[Wish, AreaLimits | None]:
        """The wish with nothing left open, and how many areas of each size are kept at most.

        The same numbers are drawn whatever is open.

        Args:
            rng: Draws what is open.
            seen: Contents of the scenes that the model was trained on, from which to draw; the
                budget of the corpus where there are none.
            is_corpus: Whether those have as many areas at most as the corpus draws for each.

        Raises:
            RequestError: If the model has seen no scene of the domain that is asked for.
        """
        if seen:
            return self._drawn_from(seen, rng, is_corpus=is_corpus)
        domain = DOMAINS[int(rng.integers(len(DOMAINS)))]
        budget = draw_budget(rng)
        limits = self._limits(budget)
        n_areas = limits.small + limits.medium + limits.large
        n_coarse, n_fine = budget.n_coarse + _MORE_COARSE, budget.n_fine + _MORE_FINE
        domain = self.domain or (domain if self.complete is None else self.complete.domain)
        return self._with_objects(Wish(domain, n_coarse, n_fine, n_areas)), limits

    def _with_objects(self, wish: Wish) -> Wish:
        """The wish with as many objects as asked for, or coarse ones as given."""
        n_coarse, n_fine = wish.n_coarse, wish.n_fine
        if self.n_objects is not None:
            n_coarse = round(self.n_objects * n_coarse / max(1, n_coarse + n_fine))
            n_fine = self.n_objects - n_coarse
        if self.complete is not None:
            n_coarse = sum(obj.is_coarse for obj in self.complete.objects)
        return replace(wish, n_coarse=n_coarse, n_fine=n_fine)

    def alike(self, seen: Sequence[Wish]) -> list[Wish]:
        """Those of the scenes seen that are of the domain that is asked for.

        Raises:
            RequestError: If some were seen, but none of this domain.
        """
        domain = self.domain if self.complete is None else self.complete.domain
        found = [wish for wish in seen if domain in {None, wish.domain}]
        if seen and not found:
            valid = ", ".join(sorted({wish.domain for wish in seen}))
            raise RequestError(
                f"domain is {domain!r}, valid: {valid}; the model was trained on no other"
            )
        return found

    def _drawn_from(
        self, seen: Sequence[Wish], rng: np.random.Generator, *, is_corpus: bool
    ) -> tuple[Wish, AreaLimits | None]:
        """The contents of one of the scenes seen, with what is asked for in their place."""
        alike = self.alike(seen)
        limits = self._limits(draw_budget(rng))
        wish = self._with_objects(alike[int(rng.integers(len(alike)))])
        if self.n_areas is not None:
            return replace(wish, n_areas=self.n_areas), limits
        return wish, limits if is_corpus else None

    def _limits(self, budget: Budget) -> AreaLimits:
        """Areas by size in the proportions of the budget."""
        drawn = replace(
            budget.areas,
            small=budget.areas.small + _MORE_SMALL,
            large=budget.areas.large + _MORE_LARGE,
        )
        if self.n_areas is None:
            return drawn
        share = self.n_areas / (drawn.small + drawn.medium + drawn.large)
        medium, large = round(share * drawn.medium), round(share * drawn.large)
        return AreaLimits(
            small=self.n_areas - medium - large,
            medium=medium,
            large=large,
            perching=round(share * drawn.perching),
        )


def _check(name: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:
        raise RequestError(f"{name} is {value}, valid: {low:g} to {high:g}")
