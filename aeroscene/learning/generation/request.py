"""Request of a user for a scene: checked fields, and the draw of everything left open."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from aeroscene.areas.needs import AreaLimits
from aeroscene.corpus.curation.curate import draw_budget
from aeroscene.feasibility import FeasibilityCfg, Feasible, make_feasible
from aeroscene.feasibility.insertion import insert, unsound
from aeroscene.feasibility.wishes.clutter import cluttered
from aeroscene.feasibility.wishes.passages import widened
from aeroscene.learning.generation.asked import area_limits, in_all
from aeroscene.learning.generation.redo import Redo
from aeroscene.learning.wishes import (
    AREAS,
    CLUTTER,
    DENSITY,
    OBJECTS,
    OUTLINE_M,
    PASSAGE_M,
    AreaCounts,
    RequestError,
    Wish,
)
from aeroscene.ranges import SEEDS
from aeroscene.scene import DOMAINS, AttributeValue, Scene, SceneDomain

_MORE_COARSE, _MORE_FINE = 2, 4
"""Coarse and fine objects beyond the budget of the corpus, whose structures bring some objects of
their own."""
Themes = Mapping[SceneDomain, Collection[str]]
"""Themes that a model knows, by domain."""
NO_THEMES: Themes = MappingProxyType({})
"""Themes of a model that knows none."""


@dataclass(frozen=True, kw_only=True)
class Request:
    """A scene to be generated; fields that are None are drawn from the seed.

    Raises:
        RequestError: If a field is out of its range, or two fields contradict each other.
    """

    seed: int
    """The same seed on the same device with the same checkpoint gives the same scene."""
    domain: SceneDomain | None = None
    theme: str | None = None
    """Theme of the place, such as `park`. With an open domain, one that has this theme is drawn."""
    n_objects: int | None = None
    """Approximate number of objects, coarse and fine."""
    n_areas: int | AreaCounts | None = None
    """Greatest number of landing areas, in all or of each class."""
    outline_m: tuple[float, float] | None = None
    """Sides of the site along x and y, m."""
    complete: Scene | None = None
    """A scene whose coarse objects stay as they are; fine ones are made for them."""
    redo: Redo | None = None
    """A region of a scene whose fine objects are drawn anew; the rest stays as it is."""
    density: float | None = None
    """Factor on the number of fine objects that is drawn."""
    clutter: float | None = None
    """Factor on the number of loose objects on ground and floors."""
    min_passage_m: float | None = None
    """Least clear width of doors and corridors, m."""
    has_relief: bool = True
    """True lets the land of an outdoor site rise gently. A given scene keeps its ground."""

    def __post_init__(self) -> None:
        SEEDS.require("seed", self.seed, RequestError)
        if self.n_objects is not None:
            OBJECTS.require("objects", self.n_objects, RequestError)
        if isinstance(self.n_areas, int):
            AREAS.require("areas", self.n_areas, RequestError)
        for name, value, limits in (
            ("density", self.density, DENSITY),
            ("clutter", self.clutter, CLUTTER),
            ("min-passage", self.min_passage_m, PASSAGE_M),
        ):
            if value is not None:
                limits.require(name, value, RequestError)
        # Both fix the number of objects, and neither may win silently.
        if self.density is not None and self.n_objects is not None:
            raise RequestError(
                f"density is {self.density:g} beside objects {self.n_objects}; "
                "valid: one of the two; both say how many objects there are"
            )
        for side in self.outline_m or ():
            OUTLINE_M.require("outline", side, RequestError)
        self._check_given()

    def _check_given(self) -> None:
        """Refuse fields that a given scene decides itself."""
        if self.given is None:
            return
        what = "to complete" if self.redo is None else "to redo"
        beside: dict[str, tuple[object, str]] = {
            "outline": (_text(self.outline_m), "the scene has an outline of its own"),
            "theme": (self.theme, "the scene stays the place that it is"),
            "domain": (self.domain, "the scene stays the place that it is"),
        }
        if self.redo is not None:
            stays = "what is outside of the region stays as it is"
            beside |= {
                "complete": (self.complete and self.complete.scene_id, "the two keep other things"),
                "objects": (self.n_objects, "about as many come as go; density has a factor"),
                "areas": (self.n_areas, stays),
                "clutter": (self.clutter, stays),
                "min-passage": (self.min_passage_m, stays),
            }
        for name, (value, reason) in beside.items():
            if value is not None:
                raise RequestError(
                    f"{name} is {value!r} beside a scene {what}; valid: one of the two; {reason}"
                )

    @property
    def given(self) -> Scene | None:
        """The scene that is to be completed, or redone in a region; None if none is given."""
        return self.complete if self.redo is None else self.redo.scene

    @property
    def kept(self) -> Scene | None:
        """The coarse part of the scene that is to be completed; None if none is."""
        if self.complete is None:
            return None
        # Areas, wishes and measures of the old scene would no longer be true.
        coarse = tuple(obj for obj in self.complete.objects if obj.is_coarse)
        return replace(self.complete, objects=coarse, interaction_areas=(), wishes={}, measured={})

    @property
    def wishes(self) -> dict[str, AttributeValue]:
        """Wishes beside domain and seed, under their names in the document of the scene.

        Wishes that were left open are absent.
        """
        asked: dict[str, AttributeValue | None] = {
            "theme": self.theme,
            "objects": self.n_objects,
            "outline": _text(self.outline_m),
            "complete": None if self.complete is None else self.complete.scene_id,
            "redo": None if self.redo is None else self.redo.scene.scene_id,
            "region": None if self.redo is None else str(self.redo.region),
            "density": self.density,
            "clutter": self.clutter,
            "min_passage": self.min_passage_m,
            "relief": None if self.has_relief else False,
        }
        if isinstance(self.n_areas, AreaCounts):
            asked |= {f"areas_{name}": count for name, count in self.n_areas.named.items()}
        else:
            asked["areas"] = self.n_areas
        return {name: value for name, value in asked.items() if value is not None}

    def prepared(self, raw: Scene, rng: np.random.Generator) -> Scene:
        """Widen doors and strew objects in a sampled scene, as far as asked for."""
        scene = replace(raw, wishes=self.wishes)
        if self.min_passage_m is not None:
            scene = widened(scene, self.min_passage_m)
        return scene if self.clutter is None else cluttered(scene, self.clutter, rng)

    def projected(
        self, raw: Scene, rng: np.random.Generator, limits: AreaLimits | None
    ) -> Feasible:
        """Make a sampled scene feasible, as far as it may be changed.

        Args:
            raw: The scene as sampled.
            rng: Source of strewn objects.
            limits: Greatest numbers of areas. A region that is drawn anew has at most as many as it
                had.
        """
        prepared = self.prepared(raw, rng)
        if self.redo is not None:
            return insert(prepared, self.redo.scene, self.redo.region)
        return make_feasible(prepared, self.demands(limits))

    def demands(self, limits: AreaLimits | None) -> FeasibilityCfg:
        """Return the requirements on the projected scene.

        Coarse objects that are given and sound do not move.
        """
        pinned = frozenset[int]()
        # Wider passages need walls that can move, and unsound objects need the projection.
        if self.kept is not None and self.min_passage_m is None and not unsound(self.kept):
            pinned = frozenset(obj.id for obj in self.kept.objects)
        least_m = self.min_passage_m or 0.0
        land_seed = self.seed if self.has_relief and self.given is None else None
        return FeasibilityCfg(
            limits=limits, least_passage_m=least_m, pinned=pinned, land_seed=land_seed
        )

    def drawn(
        self,
        rng: np.random.Generator,
        seen: Sequence[Wish] = (),
        themes: Themes = NO_THEMES,
        *,
        is_corpus: bool = False,
    ) -> tuple[Wish, AreaLimits | None]:
        """Draw everything that is open.

        The same number of random numbers is drawn whatever is open, so that a further wish does not
        change the other draws.

        Args:
            rng: Source of the draws.
            seen: Contents of the model's training scenes, of which one is drawn. If there are none,
                the budget of the corpus is drawn instead.
            themes: Themes that the model knows.
            is_corpus: True if these scenes have at most as many areas as the corpus draws for each.

        Returns:
            The wish, and the greatest number of areas of each class; None sets no limit.

        Raises:
            RequestError: If the model has seen no scene of the domain or theme asked for.
        """
        if seen:
            return self._drawn_from(self.alike(seen, themes), rng, is_corpus=is_corpus)
        domains = self.domains(themes)
        # One draw for every list of domains, so that later draws stay the same.
        domain = domains[int(rng.integers(len(DOMAINS))) % len(domains)]
        budget = draw_budget(rng)
        limits = area_limits(self.n_areas, budget)
        n_coarse, n_fine = budget.n_coarse + _MORE_COARSE, budget.n_fine + _MORE_FINE
        wish = self._with_objects(Wish(domain, n_coarse, n_fine, in_all(limits)))
        return wish, limits

    def _with_objects(self, wish: Wish) -> Wish:
        """Put the number of objects, the density or the given objects into a wish."""
        n_coarse, n_fine = wish.n_coarse, wish.n_fine
        if self.n_objects is not None:
            # Coarse and fine keep the proportion of the drawn wish.
            n_coarse = round(self.n_objects * n_coarse / max(1, n_coarse + n_fine))
            n_fine = self.n_objects - n_coarse
        if self.complete is not None:
            n_coarse = sum(obj.is_coarse for obj in self.complete.objects)
        if self.redo is not None:
            return self._redone(wish, self.redo)
        if self.density is not None:
            # A scene has at most 250 objects, and the coarse ones are needed.
            n_fine = min(round(self.density * n_fine), max(0, int(OBJECTS.high) - n_coarse))
        return replace(wish, n_coarse=n_coarse, n_fine=n_fine, theme=self.theme or "")

    def _redone(self, wish: Wish, redo: Redo) -> Wish:
        """Return the contents of the scene that stays, plus the objects that are to be drawn."""
        n_new = max(1, round((self.density or 1.0) * redo.n_wanted(wish.n_fine)))
        n_coarse = len(redo.kept.objects) - redo.n_kept_fine
        n_areas = len(redo.scene.landing_areas)
        return Wish(redo.scene.domain, n_coarse, redo.n_kept_fine + n_new, n_areas)

    def domains(self, themes: Themes) -> tuple[SceneDomain, ...]:
        """Return the domains that the scene may have: those asked for that have the theme.

        Args:
            themes: Themes that the model knows.

        Raises:
            RequestError: If there is none, because the model knows no such theme there.
        """
        domain = self.domain if self.given is None else self.given.domain
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
            raise RequestError(f"theme is {self.theme!r}{where}; valid: {valid}")
        return found

    def alike(self, seen: Sequence[Wish], themes: Themes = NO_THEMES) -> list[Wish]:
        """Return the training scenes' contents from which the wish may be drawn.

        They are of the domain asked for, and of the theme too if any of them names it.

        Args:
            seen: Contents of all training scenes.
            themes: Themes that the model knows.

        Raises:
            RequestError: If there are training scenes but none of this domain, or the model knows
                no such theme.
        """
        domains = self.domains(themes)
        found = [wish for wish in seen if wish.domain in domains]
        if seen and not found:
            valid = ", ".join(sorted({wish.domain for wish in seen}))
            raise RequestError(
                f"domain is {' or '.join(domains)!r}; valid: {valid}; "
                "the model was trained on no other"
            )
        return [wish for wish in found if wish.theme == self.theme] or found

    def _drawn_from(
        self, alike: Sequence[Wish], rng: np.random.Generator, *, is_corpus: bool
    ) -> tuple[Wish, AreaLimits | None]:
        """Draw the contents of one of these scenes, and put in what is asked for."""
        wish = self._with_objects(alike[int(rng.integers(len(alike)))])
        # Sites have other limits than rooms. Drawn even if they are not used, so that later draws
        # stay the same.
        limits = area_limits(self.n_areas, draw_budget(rng, wish.domain))
        if self.n_areas is not None:
            return replace(wish, n_areas=in_all(limits)), limits
        return wish, limits if is_corpus else None


def _text(sides_m: tuple[float, float] | None) -> str | None:
    return None if sides_m is None else f"{sides_m[0]:g},{sides_m[1]:g}"
