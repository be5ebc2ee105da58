"""Request of a user for a scene."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from types import MappingProxyType

import numpy as np

from aeroscene.areas.needs import AreaLimits
from aeroscene.corpus.curation.curate import Budget, draw_budget
from aeroscene.feasibility import FeasibilityCfg
from aeroscene.feasibility.wishes.clutter import cluttered
from aeroscene.feasibility.wishes.passages import widened
from aeroscene.learning.tokens.kinds import DOMAINS
from aeroscene.learning.tokens.skeleton import Wish
from aeroscene.scene import AttributeValue, Scene, SceneDomain, SceneError

OBJECTS = (20, 250)
"""Fewest and most objects that may be asked for."""
AREAS = (1, 200)
DENSITY = (0.2, 2.0)
CLUTTER = (1.0, 10.0)
PASSAGE_M = (0.5, 3.0)
"""Least and greatest width of doors and corridors that may be asked for."""
OUTLINE_M = (15.0, 150.0)
"""Shortest and longest side of a site."""
_MORE_COARSE, _MORE_FINE = 2, 4
"""Asked for beyond the budget of the corpus, whose structures bring some objects of their own."""
_MORE_SMALL, _MORE_LARGE = 2, 1
"""Areas asked for beyond those of the corpus: generated scenes, of which the indoor ones have less
floor, cannot always offer as many. With it averages are within 5% of the paper's."""
Themes = Mapping[SceneDomain, Collection[str]]
"""Themes that a model knows, by domain."""
NO_THEMES: Themes = MappingProxyType({})
"""Those of a model that knows of none."""


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
            _check(f"areas {name}", count, 0, AREAS[1])
        if len(self.named) == len(fields(self)):
            _check("areas in all", sum(self.named.values()), AREAS[0], 3 * AREAS[1])

    @property
    def named(self) -> dict[str, int]:
        """Counts that are not left open."""
        return {name: count for name, count in asdict(self).items() if count is not None}


@dataclass(frozen=True, kw_only=True)
class Request:
    """A scene to be generated; what is None is drawn from the seed."""

    seed: int
    """Same seed, same device, same checkpoint: same scene."""
    domain: SceneDomain | None = None
    theme: str | None = None
    """What the place is, such as park; with an open domain, of a domain that has such places."""
    n_objects: int | None = None
    """About so many, coarse and fine."""
    n_areas: int | AreaCounts | None = None
    """Landing areas, at most: in all, or of each class."""
    outline_m: tuple[float, float] | None = None
    """Sides of the site along x and y, m."""
    complete: Scene | None = None
    """A scene whose coarse objects stay as they are; fine ones are made for them."""
    density: float | None = None
    """Factor on the number of fine objects that is drawn."""
    clutter: float | None = None
    """Factor on the loose things that lie on ground and floors."""
    min_passage_m: float | None = None
    """Least clear width of doors and corridors, m."""

    def __post_init__(self) -> None:
        _check("seed", self.seed, 0, 2**63 - 1)
        if self.n_objects is not None:
            _check("objects", self.n_objects, *OBJECTS)
        if isinstance(self.n_areas, int):
            _check("areas", self.n_areas, *AREAS)
        for name, value, limits in (
            ("density", self.density, DENSITY),
            ("clutter", self.clutter, CLUTTER),
            ("min-passage", self.min_passage_m, PASSAGE_M),
        ):
            if value is not None:
                _check(name, value, *limits)
        if self.density is not None and self.n_objects is not None:
            raise RequestError(
                f"density is {self.density:g} beside objects {self.n_objects}, "
                "valid: one of the two; both say how many objects there are"
            )
        for side in self.outline_m or ():
            _check("outline", side, *OUTLINE_M)
        if self.complete is not None and self.outline_m is not None:
            raise RequestError(
                f"outline is {self.outline_m} beside a scene to complete, valid: one of the two; "
                "the scene has an outline of its own"
            )
        if self.complete is not None and self.theme is not None:
            raise RequestError(
                f"theme is {self.theme!r} beside a scene to complete, valid: one of the two; "
                "the scene stays the place that it is"
            )

    @property
    def kept(self) -> Scene | None:
        """The coarse part of the scene that is to be completed."""
        if self.complete is None:
            return None
        coarse = tuple(obj for obj in self.complete.objects if obj.is_coarse)
        return replace(self.complete, objects=coarse, interaction_areas=())

    @property
    def wishes(self) -> dict[str, AttributeValue]:
        """What is asked for beside domain and seed, as the document of the scene names it."""
        asked: dict[str, AttributeValue | None] = {
            "theme": self.theme,
            "objects": self.n_objects,
            "outline": _text(self.outline_m),
            "complete": None if self.complete is None else self.complete.scene_id,
            "density": self.density,
            "clutter": self.clutter,
            "min_passage": self.min_passage_m,
        }
        if isinstance(self.n_areas, AreaCounts):
            asked |= {f"areas_{name}": count for name, count in self.n_areas.named.items()}
        else:
            asked["areas"] = self.n_areas
        return {name: value for name, value in asked.items() if value is not None}

    def prepared(self, raw: Scene, rng: np.random.Generator) -> Scene:
        """The scene as sampled with doors widened and things strewn, as far as asked for."""
        scene = replace(raw, wishes=self.wishes)
        if self.min_passage_m is not None:
            scene = widened(scene, self.min_passage_m)
        return scene if self.clutter is None else cluttered(scene, self.clutter, rng)

    def demands(self, limits: AreaLimits | None) -> FeasibilityCfg:
        """What the projected scene has to meet."""
        return FeasibilityCfg(limits=limits, least_passage_m=self.min_passage_m or 0.0)

    def drawn(
        self,
        rng: np.random.Generator,
        seen: Sequence[Wish] = (),
        themes: Themes = NO_THEMES,
        *,
        is_corpus: bool = False,
    ) -> tuple[Wish, AreaLimits | None]:
        """The wish with nothing left open, and how many areas of each size are kept at most.

        The same numbers are drawn whatever is open.

        Args:
            rng: Draws what is open.
            seen: Contents of the scenes that the model was trained on, from which to draw; the
                budget of the corpus where there are none.
            themes: Themes that the model knows.
            is_corpus: Whether those have as many areas at most as the corpus draws for each.

        Raises:
            RequestError: If the model has seen no scene of the domain or theme asked for.
        """
        if seen:
            return self._drawn_from(self.alike(seen, themes), rng, is_corpus=is_corpus)
        domains = self.domains(themes)
        domain = domains[int(rng.integers(len(DOMAINS))) % len(domains)]
        budget = draw_budget(rng)
        limits = self._limits(budget)
        n_coarse, n_fine = budget.n_coarse + _MORE_COARSE, budget.n_fine + _MORE_FINE
        wish = self._with_objects(Wish(domain, n_coarse, n_fine, _in_all(limits)))
        return wish, limits

    def _with_objects(self, wish: Wish) -> Wish:
        """The wish with as many objects, and as densely, as asked for, or coarse ones as given."""
        n_coarse, n_fine = wish.n_coarse, wish.n_fine
        if self.n_objects is not None:
            n_coarse = round(self.n_objects * n_coarse / max(1, n_coarse + n_fine))
            n_fine = self.n_objects - n_coarse
        if self.complete is not None:
            n_coarse = sum(obj.is_coarse for obj in self.complete.objects)
        if self.density is not None:
            n_fine = min(round(self.density * n_fine), max(0, OBJECTS[1] - n_coarse))
        return replace(wish, n_coarse=n_coarse, n_fine=n_fine, theme=self.theme or "")

    def domains(self, themes: Themes) -> tuple[SceneDomain, ...]:
        """Domains that the scene may have: what is asked for, as far as it has the theme.

        Raises:
            RequestError: If there is none, since the model knows no such theme there.
        """
        domain = self.domain if self.complete is None else self.complete.domain
        asked = DOMAINS if domain is None else (domain,)
        if self.theme is None:
            return asked
        found: tuple[SceneDomain, ...] = tuple(
            each for each in asked if self.theme in themes.get(each, ())
        )
        if not found:
            where = "" if domain is None else f" for domain {domain!r}"
            known = sorted({theme for each in asked for theme in themes.get(each, ())})
            valid = ", ".join(known) or "no theme; the model knows none, --preset default does"
            raise RequestError(f"theme is {self.theme!r}{where}, valid: {valid}")
        return found

    def alike(self, seen: Sequence[Wish], themes: Themes = NO_THEMES) -> list[Wish]:
        """Those of the scenes seen that are of the domain that is asked for.

        They are of the theme too, where any scene seen says that it is.

        Raises:
            RequestError: If some were seen, but none of this domain, or the model knows no such
                theme.
        """
        domains = self.domains(themes)
        found = [wish for wish in seen if wish.domain in domains]
        if seen and not found:
            valid = ", ".join(sorted({wish.domain for wish in seen}))
            raise RequestError(
                f"domain is {' or '.join(domains)!r}, valid: {valid}; "
                "the model was trained on no other"
            )
        return [wish for wish in found if wish.theme == self.theme] or found

    def _drawn_from(
        self, alike: Sequence[Wish], rng: np.random.Generator, *, is_corpus: bool
    ) -> tuple[Wish, AreaLimits | None]:
        """The contents of one of these scenes, with what is asked for in their place."""
        limits = self._limits(draw_budget(rng))
        wish = self._with_objects(alike[int(rng.integers(len(alike)))])
        if self.n_areas is not None:
            return replace(wish, n_areas=_in_all(limits)), limits
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
        if isinstance(self.n_areas, AreaCounts):
            return replace(drawn, **self.n_areas.named)
        share = self.n_areas / (drawn.small + drawn.medium + drawn.large)
        medium, large = round(share * drawn.medium), round(share * drawn.large)
        return AreaLimits(
            small=self.n_areas - medium - large,
            medium=medium,
            large=large,
            perching=round(share * drawn.perching),
        )


def _in_all(limits: AreaLimits) -> int:
    """Landing areas of all classes."""
    return limits.small + limits.medium + limits.large


def _text(sides_m: tuple[float, float] | None) -> str | None:
    return None if sides_m is None else f"{sides_m[0]:g},{sides_m[1]:g}"


def _check(name: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:
        raise RequestError(f"{name} is {value}, valid: {low:g} to {high:g}")
