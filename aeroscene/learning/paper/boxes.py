"""Boxes with categories as a skeleton and its geometry: what a flat layout becomes a scene by."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from jaxtyping import Bool, Float, Int

from aeroscene.learning.paper.layouts import NO_REGION, turned
from aeroscene.learning.tokens.geometry import Geometry
from aeroscene.learning.tokens.kinds import DOMAINS, OPENINGS, Vocabulary
from aeroscene.learning.tokens.skeleton import Skeleton
from aeroscene.scene import SceneDomain
from aeroscene.scene.catalogue import CATALOGUE, COARSE_COUNT


@dataclass(frozen=True, eq=False)
class FlatBoxes:
    """Upright boxes in the world, in any order."""

    category: Int[np.ndarray, " n"]
    """Numbers from 1."""
    center_enu_m: Float[np.ndarray, "n 3"]
    yaw_rad: Float[np.ndarray, " n"]
    size_m: Float[np.ndarray, "n 3"]
    region: Int[np.ndarray, " n"] | None = None
    """Row of the coarse object that each fine one belongs to, or `NO_REGION`; None if unknown."""

    def turned(self, yaw_rad: float) -> Self:
        """The boxes turned about the origin, counter-clockwise from above."""
        center_enu_m = turned(self.center_enu_m, yaw_rad)
        return replace(self, center_enu_m=center_enu_m, yaw_rad=self.yaw_rad + yaw_rad)


def as_skeleton(
    boxes: FlatBoxes, domain: SceneDomain, vocabulary: Vocabulary, rng: np.random.Generator
) -> tuple[Skeleton, Geometry]:
    """A skeleton of two levels and its geometry.

    A fine object without a region belongs to the coarse one whose centre is nearest, as in the
    paper's coarse-to-fine guidance. The kind within a category is drawn as often as the training
    scenes had it; a category of which there is no kind becomes the first of which there is one.
    """
    is_usable = usable_categories(vocabulary)
    category = np.where(is_usable[boxes.category], boxes.category, is_usable.argmax())
    order = np.argsort(category > COARSE_COUNT, kind="stable")
    category, center = category[order], boxes.center_enu_m[order]
    n_coarse = int((category <= COARSE_COUNT).sum())
    parent = np.zeros(len(order), dtype=np.int64)
    if boxes.region is not None:
        place = np.append(np.argsort(order), NO_REGION)
        parent[n_coarse:] = 1 + place[boxes.region[order]][n_coarse:]
    elif n_coarse:
        away = np.linalg.norm(center[n_coarse:, None] - center[None, :n_coarse], axis=-1)
        parent[n_coarse:] = 1 + away.argmin(axis=1)
    kinds = [_draw_kind(int(number), vocabulary, rng) for number in category]
    skeleton = Skeleton(
        domain,
        np.array([DOMAINS.index(domain), *kinds]),
        np.array([0, *parent]),
        1 + n_coarse,
    )
    half_m = np.abs(center[:, :2]).max(axis=0, initial=1.0)
    return skeleton, Geometry(
        np.vstack([[0.0, 0.0, 0.0], center]),
        np.concatenate([[0.0], boxes.yaw_rad[order]]),
        np.vstack([[*(2 * half_m), 1.0], boxes.size_m[order]]),
        np.full((len(skeleton), len(OPENINGS)), np.nan),
    )


def usable_categories(vocabulary: Vocabulary) -> Bool[np.ndarray, " categories"]:
    """Whether there is a kind to draw of each category, by its number; there is no category 0."""
    return np.array([False, *(bool(_kinds_of(number, vocabulary)) for number in sorted(CATALOGUE))])


def _kinds_of(category: int, vocabulary: Vocabulary) -> list[int]:
    """Kinds without openings, since a flat layout has no channels for them."""
    return [
        number
        for number in np.flatnonzero(vocabulary.category_id == category).tolist()
        if not vocabulary.kinds[number].openings
    ]


def _draw_kind(category: int, vocabulary: Vocabulary, rng: np.random.Generator) -> int:
    kinds = _kinds_of(category, vocabulary)
    counts = [sum(look.count for look in vocabulary.looks[number]) for number in kinds]
    return kinds[rng.choice(len(kinds), p=np.array(counts) / sum(counts))]
