"""Mapping of the categories of other sources to our 70, with a report on every object.

Sources have hundreds of names, and new ones appear with every version. Tables cover the known
catalogues; for all other names the last known word decides, because English puts the kind last.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any, Literal

from aeroscene.layouts.document import LayoutObject
from aeroscene.layouts.tables import FORMS, SAME, STAND_INS, SUPER_CATEGORIES, WORDS
from aeroscene.scene import Vector3
from aeroscene.scene.catalogue import by_name

Fit = Literal["same", "stand-in", "by word", "by super-category"]

# Detached houses are lower and smaller than blocks; what is smaller still is a garage or a shed.
_GARAGE_M = (8.0, 3.5)
_HOUSE_M = (16.0, 8.0)


@dataclass(frozen=True, slots=True)
class Match:
    """Our category for a name of a source, and how well it fits."""

    category: str
    fit: Fit


def match(obj: LayoutObject) -> Match | None:
    """Our category for an object of a layout; None if nothing of ours is close."""
    found = match_name(obj.category)
    if found is None and obj.super_category in SUPER_CATEGORIES:
        found = Match(SUPER_CATEGORIES[obj.super_category], "by super-category")
    # A name such as "building" says nothing of the kind, so that the size decides.
    if found is not None and found.category == "building":
        return Match(building_kind(obj.s), found.fit)
    return found


@cache
def match_name(name: str) -> Match | None:
    """Our category for a name: by the tables, or else by its last known word."""
    tables = _tables()
    if name in tables:
        return tables[name]
    words = _words(name)
    for end in range(len(words), 0, -1):
        # Two words before one: a coffee table is no table.
        for start in (end - 2, end - 1):
            category = _known_words().get(" ".join(words[max(start, 0) : end]))
            if category is not None:
                return Match(category, "same" if end - start == len(words) else "by word")
    return None


@cache
def _known_words() -> Mapping[str, str]:
    """Our category under each phrase of one or two words that names it."""
    words = {word: category for category, group in WORDS.items() for word in group}
    return words | {name.replace("_", " "): name for name in by_name()}


@cache
def _tables() -> Mapping[str, Match]:
    matches = {
        name: Match(category, "stand-in") for category, names in STAND_INS.items() for name in names
    }
    matches |= {name: Match(category, "same") for category, names in SAME.items() for name in names}
    return matches


def _words(name: str) -> list[str]:
    """Words of a name in lower case and singular: `SM_PalmTrees03` is sm palm tree."""
    spaced = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name)
    words = re.findall("[a-z]+", spaced.lower())
    # A word of more than three letters loses its plural, but "glass" keeps its s.
    return [word[:-1] if len(word) > 3 and word[-1] == "s" != word[-2] else word for word in words]


def form_of(name: str) -> str | None:
    """Form of our shape for a name of a source, if one is closer than the others."""
    return next((form for form, names in FORMS.items() if name in names), None)


def building_kind(size_m: Vector3) -> str:
    """Category of a building of unknown use by its size: garage, house, tower or building."""
    side, height = max(size_m[:2]), size_m[2]
    if side <= _GARAGE_M[0] and height <= _GARAGE_M[1]:
        return "garage"
    if side <= _HOUSE_M[0] and height <= _HOUSE_M[1]:
        return "house"
    return "tower" if side <= _HOUSE_M[0] and height > 1.5 * side else "building"


@dataclass(frozen=True, slots=True)
class MappingReport:
    """Report on the mapping of the objects of one scene or, added up, of many."""

    n_scenes: int = 0
    n_objects: int = 0
    """Number of objects of the source, without the invalid ones."""
    mapped: Mapping[tuple[str, str, Fit], int] = field(default_factory=dict)
    """Number of objects under the source's category, ours, and the quality of the fit."""
    unmapped: Mapping[str, int] = field(default_factory=dict)
    """Number of objects under a category of the source that has no close category of ours."""
    unmapped_first: Mapping[str, str] = field(default_factory=dict)
    """Scene and object of the first occurrence of each unmapped category."""
    dropped: Mapping[str, int] = field(default_factory=dict)
    """Number of objects under the reason for which they were left out despite a category."""
    invalid: tuple[str, ...] = ()
    """Objects and scenes that break a rule and were left out, one line each."""

    @property
    def n_mapped(self) -> int:
        """Number of objects that are in our scene."""
        return sum(self.mapped.values())

    @property
    def by_category(self) -> Mapping[str, int]:
        """Number of objects under each of our categories, the most frequent first."""
        counts: Counter[str] = Counter()
        for (_, category, _), count in self.mapped.items():
            counts[category] += count
        return dict(sorted(counts.items(), key=lambda item: (-item[1], item[0])))

    @property
    def by_fit(self) -> Mapping[str, int]:
        """Number of objects under each quality of the fit."""
        counts: Counter[str] = Counter()
        for (_, _, fit), count in self.mapped.items():
            counts[fit] += count
        return dict(sorted(counts.items()))

    @property
    def unmapped_lines(self) -> list[str]:
        """One line for each category that did not map, naming scene, object and field."""
        return [
            f"{place}: {unknown_category(name)}; left out, {self.unmapped[name]} of them"
            for name, place in sorted(self.unmapped_first.items())
        ]

    def __add__(self, other: MappingReport) -> MappingReport:
        return MappingReport(
            n_scenes=self.n_scenes + other.n_scenes,
            n_objects=self.n_objects + other.n_objects,
            mapped=_sum(self.mapped, other.mapped),
            unmapped=_sum(self.unmapped, other.unmapped),
            # The first report's places stand, since it came first.
            unmapped_first={**other.unmapped_first, **self.unmapped_first},
            dropped=_sum(self.dropped, other.dropped),
            invalid=self.invalid + other.invalid,
        )

    def to_plain(self) -> dict[str, Any]:
        """The report as plain data for JSON."""
        names: dict[str, dict[str, Any]] = {}
        for (name, category, fit), count in sorted(self.mapped.items()):
            entry = names.setdefault(name, {"count": 0, "fit": fit, "categories": {}})
            entry["count"] += count
            entry["categories"][category] = count
        return {
            "scenes": self.n_scenes,
            "objects": self.n_objects,
            "mapped": self.n_mapped,
            "mapped_by_category": dict(self.by_category),
            "mapped_by_fit": dict(self.by_fit),
            "mapped_by_name": names,
            "unmapped": dict(sorted(self.unmapped.items())),
            "unmapped_lines": self.unmapped_lines,
            "dropped": dict(sorted(self.dropped.items())),
            "invalid": len(self.invalid),
            "invalid_lines": list(self.invalid),
        }


def unknown_category(name: str) -> str:
    """Describe in one line the fault of a category that did not map."""
    return f"category is {name!r}; valid: one that docs/layouts.md lists or a word of ours in it"


def _sum(first: Mapping[Any, int], second: Mapping[Any, int]) -> dict[Any, int]:
    return dict(Counter(first) + Counter(second))
