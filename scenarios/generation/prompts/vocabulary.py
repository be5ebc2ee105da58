"""The vocabulary of prompts: things and places with their words, read from the tables beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

import msgspec

from aeroscene.scene.catalogue import (
    COVERS,
    FLOORS,
    LEAFY,
    ROOFS,
    ROOMS,
    ROUND,
    TWO_SIDED,
    WATER,
    by_name,
)
from scenarios.generation.prompts.wishes import Relation, RelationName, named, spoken

_FOLDER = Path(__file__).parent
_ES = ("s", "x", "z", "ch", "sh")
_SAME = frozenset(("grass", "steps", "greenery", "railings", "parking"))
"""Nouns that are their own plural."""


class Part(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Objects that must stand about the heart of a thing."""

    thing: str
    least: int
    relation: RelationName | None = None
    """None is anywhere within the distance at the same level, beneath the heart as well."""
    within_m: float = 0.0


class Thing(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Something that can be asked for and found in a scene; `things.toml` says what fields mean."""

    words: tuple[str, ...] = ()
    hearts: tuple[str, ...] = ()
    form: str = ""
    use: tuple[str, ...] = ()
    parts: tuple[Part, ...] = ()
    cluster_m: float = 0.0
    least: int = 1
    long: float = 1.0
    least_m: float = 0.0
    themes: tuple[str, ...] = ()


class Place(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A theme and its words; `themes.toml` says what fields mean."""

    words: tuple[str, ...]
    weak: tuple[str, ...] = ()
    nearest: tuple[str, ...] = ()
    things: dict[str, str] = {}
    is_indoor: bool = False


@cache
def things() -> Mapping[str, Thing]:
    """Everything that can be asked for by name: all categories, and what the table has beside."""
    table = msgspec.toml.decode((_FOLDER / "things.toml").read_bytes(), type=dict[str, Thing])
    found = {name: table.get(name, Thing()) for name in by_name()}
    # A thing that a later catalogue has no category for any more is none.
    return found | {name: each for name, each in table.items() if _is_known(name, table)}


@cache
def places() -> Mapping[str, Place]:
    """Words of each theme."""
    return msgspec.toml.decode((_FOLDER / "themes.toml").read_bytes(), type=dict[str, Place])


@cache
def categories_of(name: str) -> frozenset[str]:
    """Categories of the objects that may be the heart of a thing."""
    thing = things()[name]
    if not thing.hearts:
        return frozenset({name})
    return frozenset[str]().union(*map(categories_of, thing.hearts))


@cache
def has_front(name: str) -> bool:
    """Whether a thing has a front, so that something can be behind it."""
    thing = things()[name]
    frontless = COVERS | LEAFY | ROUND | TWO_SIDED
    return not thing.cluster_m and categories_of(name).isdisjoint(frontless)


def unmeasurable(wish: Relation) -> str | None:
    """Why a relation cannot be measured; None where it can."""
    if wish.relation in {"in_front_of", "behind"} and not has_front(wish.host):
        return f"{named(wish.host)} has no front"
    if wish.relation == "facing" and not has_front(wish.thing):
        return f"{named(wish.thing)} has no front"
    return None


@cache
def domains_of(name: str) -> frozenset[str]:
    """Domains in which a thing may stand, by the supports of its hearts."""
    found: set[str] = set()
    for category in categories_of(name):
        carried_by = set(by_name()[category].supports)
        if carried_by & (FLOORS | {"furniture"}) or things()[name].use or category in ROOMS:
            found.add("indoor")
        if carried_by & (ROOFS | WATER | {"ground"}):
            found.add("outdoor")
    return frozenset(found)


def phrases(name: str, words: Sequence[str]) -> dict[str, bool]:
    """Words for something with whether each is a plural, those of its name among them."""
    own = [spoken(name), *words]
    return {plural(each): True for each in own} | dict.fromkeys(own, False)


def plural(words: str) -> str:
    """Plural of a noun phrase, whose noun is the last word before `of`, `with` or `and`."""
    for joint in (" of ", " with ", " and "):
        head, found, rest = words.partition(joint)
        if found:
            return f"{plural(head)}{joint}{rest}"
    before, _, noun = words.rpartition(" ")
    if noun in _SAME:
        many = noun
    elif noun.endswith(("elf", "leaf")):
        many = f"{noun[:-1]}ves"
    elif noun.endswith(_ES):
        many = f"{noun}es"
    elif noun.endswith("y") and noun[-2:-1] not in "aeiou":
        many = f"{noun[:-1]}ies"
    else:
        many = f"{noun}s"
    return f"{before} {many}".strip()


def _is_known(name: str, table: Mapping[str, Thing]) -> bool:
    thing = table[name]
    if not thing.hearts:
        return name in by_name()
    others = (*thing.hearts, *(part.thing for part in thing.parts))
    return all(
        other in by_name() or (other in table and _is_known(other, table)) for other in others
    )
