"""Wishes of a prompt as data.

Our parser and a language model give the same structure, so everything behind them is written once.
Types bound every text and number, because a language model's answer is decoded straight into them.
`checked` then refuses wishes that contradict each other.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal, TypeVar

import msgspec

from aeroscene.learning.wishes import AREAS, CLUTTER, DENSITY, OBJECTS, OUTLINE_M, PASSAGE_M
from aeroscene.ranges import Range
from aeroscene.scene import SceneDomain, SceneError

MOST_COUNT = int(OBJECTS.high)
"""Largest count of one thing, because a scene has no more objects."""
COUNTS = Range(0, MOST_COUNT)
"""Numbers of one thing that can be asked for."""
_MOST_WISHES = 24
_Name = Annotated[str, msgspec.Meta(max_length=60)]
_Words = Annotated[str, msgspec.Meta(max_length=200)]
_Whole = Annotated[int, msgspec.Meta(ge=0, le=1_000_000)]
_Grade = Literal["easy", "medium", "hard"]
RelationName = Literal[
    "on",
    "on_roof",
    "over",
    "under",
    "inside",
    "next_to",
    "near",
    "in_front_of",
    "behind",
    "facing",
    "between",
    "along",
    "around",
]


class PromptError(SceneError):
    """A prompt cannot be read or met; the message says what it asks for and what is valid."""


class Count(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A wish for a number of things of one name."""

    thing: _Name
    """Name of the vocabulary."""
    least: _Whole = 1
    most: _Whole | None = None
    """Greatest number; None sets no limit."""
    said: _Words = ""
    """Words of the prompt that it comes from."""

    @property
    def number(self) -> str:
        """The number in words, such as `2` or `at least 3`."""
        if self.most is None:
            return f"at least {self.least}"
        if self.most == self.least:
            return str(self.least)
        return f"{self.least} to {self.most}" if self.least else f"at most {self.most}"

    @property
    def title(self) -> str:
        """Name of the wish in tables and documents."""
        return spoken(self.thing)

    def is_met(self, n: int) -> bool:
        """Return true if a number of things lies within the limits."""
        return self.least <= n and (self.most is None or n <= self.most)

    def off(self, n: int) -> float:
        """Return by how much a number misses the limits, as a share of the least number.

        Args:
            n: Number of things in a scene.

        Returns:
            0 within the limits. For example, 1 of at least 4 is off by 0.75.
        """
        above = n - self.most if self.most is not None else 0
        return max(self.least - n, above, 0) / max(1, self.least)


class Relation(Count, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A wish for a number of things that stand in a relation to a host."""

    relation: RelationName
    host: _Name
    other: _Name = ""
    """Second host of `between`."""

    @property
    def title(self) -> str:
        """Name of the wish in tables and documents."""
        hosts = f"{spoken(self.host)} and {spoken(self.other)}" if self.other else spoken(self.host)
        relation = "on roof of" if self.relation == "on_roof" else spoken(self.relation)
        return f"{spoken(self.thing)} {relation} {hosts}"


T = TypeVar("T", bound=Count)


class Reading(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """An option that words of the prompt set."""

    option: _Name
    said: _Words


class Wishes(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Everything that a prompt asks for; None and empty stand for what it leaves open."""

    domain: SceneDomain | None = None
    theme: _Name | None = None
    objects: _Whole | None = None
    """Approximate number of objects, coarse and fine."""
    areas: _Whole | None = None
    """Greatest number of landing areas."""
    density: float | None = None
    clutter: float | None = None
    outline_m: tuple[float, float] | None = None
    """Sides of the site, east and north, m."""
    min_passage_m: float | None = None
    difficulty: _Grade | None = None
    counts: Annotated[tuple[Count, ...], msgspec.Meta(max_length=_MOST_WISHES)] = ()
    relations: Annotated[tuple[Relation, ...], msgspec.Meta(max_length=_MOST_WISHES)] = ()
    readings: Annotated[tuple[Reading, ...], msgspec.Meta(max_length=_MOST_WISHES)] = ()
    """Words from which the options above follow."""
    not_understood: Annotated[tuple[_Words, ...], msgspec.Meta(max_length=4 * _MOST_WISHES)] = ()

    @property
    def demands(self) -> tuple[Count, ...]:
        """Counts and relations, which are measured on every draw."""
        return (*self.counts, *self.relations)

    @property
    def is_empty(self) -> bool:
        """True if nothing is asked for; words that were not understood do not count."""
        return msgspec.structs.replace(self, readings=(), not_understood=()) == Wishes()


def spoken(name: str) -> str:
    """Return a name as people write it: `street_lamp` becomes `street lamp`."""
    return name.replace("_", " ")


def named(name: str) -> str:
    """Return a name with its article: `an apple tree`."""
    return f"{'an' if name[0] in 'aeiou' else 'a'} {spoken(name)}"


def checked(wishes: Wishes) -> Wishes:
    """Return the wishes, with counts of the same thing joined.

    Args:
        wishes: Wishes as they were read.

    Raises:
        PromptError: If a number is out of its range, or two wishes contradict each other.
    """
    _require_ranges(wishes)
    counts = _joined(wishes.counts)
    relations = _joined(wishes.relations)
    found = msgspec.structs.replace(wishes, counts=counts, relations=relations)
    for fault in _faults(found):
        raise PromptError(fault)
    return found


def _require_ranges(wishes: Wishes) -> None:
    numbers = [
        ("objects", OBJECTS, wishes.objects),
        ("areas", AREAS, wishes.areas),
        ("density", DENSITY, wishes.density),
        ("clutter", CLUTTER, wishes.clutter),
        ("min-passage", PASSAGE_M, wishes.min_passage_m),
        *(("outline", OUTLINE_M, side_m) for side_m in wishes.outline_m or ()),
    ]
    for name, limits, value in numbers:
        if value is not None:
            limits.require(f"prompt: {name}", value, PromptError)


def _joined(demands: tuple[T, ...]) -> tuple[T, ...]:
    """Return one demand for each title, which meets all demands of that title."""
    found: dict[str, T] = {}
    for each in demands:
        _require_number(each)
        before = found.get(each.title)
        found[each.title] = each if before is None else _both(before, each)
    return tuple(found.values())


def _require_number(demand: Count) -> None:
    for number in (demand.least, *([] if demand.most is None else [demand.most])):
        if fault := COUNTS.fault(f"prompt: number of {demand.title}", number):
            raise PromptError(fault)
    if demand.most is not None and demand.most < demand.least:
        raise PromptError(
            f"prompt asks for at least {demand.least} and at most {demand.most} of "
            f"{demand.title}; valid: the smaller number first"
        )


def _both(first: T, second: T) -> T:
    limits = [each.most for each in (first, second) if each.most is not None]
    least, most = max(first.least, second.least), min(limits, default=None)
    if most is not None and most < least:
        raise PromptError(
            f"prompt asks for {first.number} and for {second.number} of {first.title}; "
            "valid: one of the two"
        )
    # Both words are kept within the limit of a text, so that the user sees where they come from.
    said = ", ".join(dict.fromkeys(filter(None, (first.said, second.said))))[:200]
    return msgspec.structs.replace(first, least=least, most=most, said=said)


def _faults(wishes: Wishes) -> Iterator[str]:
    """Yield a line for each contradiction between wishes."""
    limits = {each.thing: each.most for each in wishes.counts if each.most is not None}
    for each in wishes.relations:
        # A relation with a subject needs a host, but one host is enough for all.
        for name, least in ((each.thing, each.least), (each.host, min(each.least, 1))):
            if limits.get(name, least) < least:
                yield (
                    f"prompt asks for {each.number} of {each.title} and for at most "
                    f"{limits[name]} {spoken(name)}; valid: one of the two"
                )
    # Each counted thing needs an object at least. Subjects of relations may be among them.
    least = sum(each.least for each in wishes.counts)
    most = MOST_COUNT if wishes.objects is None else wishes.objects
    if least > most:
        yield f"prompt asks for {least} things in all; valid: at most {most} objects"
