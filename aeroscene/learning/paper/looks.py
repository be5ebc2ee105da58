"""Looks of objects beside their boxes: shape, colour, finish.

The paper's objects are (p, q, s, c) and have no looks. A drawn layout takes its looks from the
training scenes, as often as objects of the category had them there.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Annotated

import msgspec
import numpy as np
from jaxtyping import Bool

from aeroscene.scene import AttributeValue, ObjectDomain, Scene
from aeroscene.scene.catalogue import CATALOGUE

_OPENINGS = ("door_m", "window_m")
"""Objects with one of these attributes are left out: a flat layout has no channels for the place of
an opening."""


class Look(msgspec.Struct, frozen=True):
    """Attributes that objects of a category have in training scenes."""

    domain: ObjectDomain
    attributes: dict[str, AttributeValue]
    count: Annotated[int, msgspec.Meta(ge=1)]

    @property
    def is_shared(self) -> bool:
        """True if all objects of the category in one room share the look."""
        return self.domain == "indoor"


@dataclass(frozen=True)
class Looks:
    """Looks of a corpus by the name of the category, the commonest first."""

    by_category: Mapping[str, tuple[Look, ...]]

    @classmethod
    def from_scenes(cls, scenes: Iterable[Scene]) -> Looks:
        """Count the looks of scenes; their order does not matter."""
        counts: defaultdict[str, Counter[tuple[ObjectDomain, bytes]]] = defaultdict(Counter)
        for scene in scenes:
            for obj in scene.objects:
                if not any(name in obj.attributes for name in _OPENINGS):
                    # As text, because dictionaries cannot be counted; sorted,
                    # so that equal ones agree.
                    text = msgspec.json.encode(obj.attributes, order="sorted")
                    counts[obj.category][obj.domain, text] += 1
        return cls({name: _ranked(counts[name]) for name in sorted(counts)})

    def to_json(self) -> str:
        """Write the looks as text, which `from_json` reads."""
        return msgspec.json.encode(self.by_category).decode()

    @classmethod
    def from_json(cls, text: str) -> Looks:
        """Read the text of `to_json`.

        Raises:
            msgspec.DecodeError: If the text is malformed.
            ValueError: If no category has a look.
        """
        looks = cls(msgspec.json.decode(text, type=dict[str, tuple[Look, ...]]))
        if not looks.is_known.any():
            raise ValueError("no category has a look")
        return looks

    @property
    def is_known(self) -> Bool[np.ndarray, " categories"]:
        """True for categories with at least one look, by number; there is no category 0."""
        known = [bool(self.by_category.get(CATALOGUE[c].name)) for c in sorted(CATALOGUE)]
        return np.array([False, *known])

    def draw(self, category: int, rng: np.random.Generator) -> Look:
        """Draw a look of a category, in proportion to its count.

        Args:
            category: Number of a category that `is_known` marks.
            rng: Source of the draw.
        """
        looks = self.by_category[CATALOGUE[category].name]
        share = np.array([look.count for look in looks], dtype=float)
        return looks[rng.choice(len(looks), p=share / share.sum())]


def _ranked(counts: Counter[tuple[ObjectDomain, bytes]]) -> tuple[Look, ...]:
    # Ties are broken by text, so that the order of the scenes does not matter.
    ranked = sorted(counts.items(), key=lambda item: (-item[1], item[0]))
    return tuple(Look(domain, msgspec.json.decode(text), count) for (domain, text), count in ranked)
