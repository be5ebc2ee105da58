"""Kinds of objects: category, the attributes that shape it, and its attachment.

A category says too little to know how tall a thing is or where it stands: a bench in a hall and a
bench in a park share one. A kind adds the discrete attributes that decide an object's shape and
the way it hangs on its parent. Kinds are counted in a corpus, not listed: a corpus of other
categories has a vocabulary of its own.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, get_args

import msgspec
import numpy as np
from jaxtyping import Int

from aeroscene.learning.tokens.placed import ATTACHED_M, SITE, Placed, placed_objects
from aeroscene.scene import AttributeValue, ObjectDomain, Scene, SceneDomain, SceneObject
from aeroscene.scene.catalogue import CATALOGUE

Attachment = Literal["top", "lift", "free"]
"""Underside on the parent's upper face; at the usual height above its underside; anywhere."""

DOMAINS: tuple[SceneDomain, ...] = get_args(SceneDomain)
"""Kinds 0, 1 and 2 are the sites of these: the flight volume, parent of what has none."""

OPENINGS = (
    "door_m",
    "door_offset_m",
    "door_height_m",
    "window_m",
    "window_offset_m",
    "window_sill_m",
    "window_height_m",
)
"""Continuous attributes: they are diffused beside position, heading and size."""
_SHAPING = ("form", "is_enterable", "is_start", "rows", "storeys", "use", "zebra_end")
"""Discrete attributes that decide what shape an object has."""
_USUAL_SHARE = 0.25
"""A height above the parent's underside is usual where this share of the pairs keeps it."""
_NO_LIFT = math.nan


class Kind(msgspec.Struct, frozen=True, order=True):
    """Objects that differ in size, place and looks only."""

    category: str
    domain: ObjectDomain
    attachment: Attachment
    is_aligned: bool
    """Whether the heading is a multiple of a quarter turn to the parent's."""
    openings: tuple[str, ...] = ()
    """Which of `OPENINGS` an object has."""
    attributes: tuple[tuple[str, AttributeValue], ...] = ()
    """Attributes that decide the shape, sorted by name."""

    @property
    def is_start(self) -> bool:
        """Whether flights start on it."""
        return ("is_start", True) in self.attributes


class Looks(msgspec.Struct, frozen=True):
    """One way that objects of a kind were found to look: colour, wood, finish."""

    attributes: dict[str, AttributeValue]
    count: int


class _Document(msgspec.Struct):
    kinds: tuple[Kind, ...]
    looks: tuple[tuple[Looks, ...], ...]
    lifts_m: dict[str, float]


@dataclass(frozen=True)
class Vocabulary:
    """The kinds of a corpus; equal corpora give equal vocabularies."""

    kinds: tuple[Kind, ...]
    looks: tuple[tuple[Looks, ...], ...]
    """How objects of each kind look, the commonest first."""
    lifts_m: Mapping[tuple[str, str], float]
    """Usual height of an underside above the parent's, by the categories of child and parent."""

    @property
    def n_kinds(self) -> int:
        """Kinds, sites included."""
        return len(self.kinds)

    @cached_property
    def category_id(self) -> Int[np.ndarray, " kinds"]:
        """Number in the catalogue of each kind; 0 for sites and foreign categories."""
        known = {category.name: category.id for category in CATALOGUE.values()}
        return np.array([known.get(kind.category, 0) for kind in self.kinds])

    def to_json(self) -> str:
        """The vocabulary as text."""
        lifts = {f"{child}<{parent}": v for (child, parent), v in sorted(self.lifts_m.items())}
        return msgspec.json.encode(_Document(self.kinds, self.looks, lifts)).decode()

    @staticmethod
    def from_json(text: str) -> Vocabulary:
        """What `to_json` wrote.

        Raises:
            msgspec.DecodeError: If it is not that.
        """
        document = msgspec.json.decode(text, type=_Document)
        pairs = {tuple(name.split("<")): value for name, value in document.lifts_m.items()}
        lifts = {(pair[0], pair[1]): value for pair, value in pairs.items()}
        return Vocabulary(document.kinds, document.looks, lifts)


def count_kinds(scenes: Iterable[Scene]) -> Vocabulary:
    """The vocabulary of a corpus."""
    placed = [each for scene in scenes for each in placed_objects(scene)]
    lifts_m = _usual_lifts(placed)
    looks: defaultdict[Kind, Counter[str]] = defaultdict(Counter)
    for each in placed:
        looks[_kind(each, lifts_m)][_looks(each.obj)] += 1
    kinds = sorted(looks)
    sites = (_site(domain) for domain in DOMAINS)
    return Vocabulary(
        (*sites, *kinds),
        (((),) * len(DOMAINS) + tuple(_ranked(looks[kind]) for kind in kinds)),
        lifts_m,
    )


def _site(domain: SceneDomain) -> Kind:
    return Kind(SITE, "outdoor", "lift", is_aligned=True, attributes=(("domain", domain),))


def _usual_lifts(placed: Sequence[Placed]) -> dict[tuple[str, str], float]:
    heights: defaultdict[tuple[str, str], Counter[float]] = defaultdict(Counter)
    for each in placed:
        if not each.is_on_top:
            heights[each.obj.category, each.category][round(each.rise_m, 2) + 0.0] += 1
    lifts = {}
    for names in sorted(heights):
        height, count = min(heights[names].items(), key=lambda item: (-item[1], item[0]))
        if count >= _USUAL_SHARE * heights[names].total():
            lifts[names] = height
    return lifts


def _kind(placed: Placed, lifts_m: Mapping[tuple[str, str], float]) -> Kind:
    obj = placed.obj
    return Kind(
        obj.category,
        obj.domain,
        _attachment(placed, lifts_m),
        is_aligned=placed.is_aligned,
        openings=tuple(name for name in OPENINGS if name in obj.attributes),
        attributes=tuple((k, obj.attributes[k]) for k in _SHAPING if k in obj.attributes),
    )


def _attachment(placed: Placed, lifts_m: Mapping[tuple[str, str], float]) -> Attachment:
    if placed.is_on_top:
        return "top"
    lift = lifts_m.get((placed.obj.category, placed.category), _NO_LIFT)
    return "lift" if abs(placed.rise_m - lift) < ATTACHED_M else "free"


def _looks(obj: SceneObject) -> str:
    """The other discrete attributes, as a sorted text."""
    rest = {k: v for k, v in obj.attributes.items() if k not in _SHAPING and k not in OPENINGS}
    return msgspec.json.encode(dict(sorted(rest.items()))).decode()


def _ranked(counts: Counter[str]) -> tuple[Looks, ...]:
    ranked = sorted(counts.items(), key=lambda item: (-item[1], item[0]))
    return tuple(Looks(msgspec.json.decode(text), count) for text, count in ranked)
