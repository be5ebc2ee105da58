"""The words that the parser knows, each with its kind and its meaning.

Nouns come from `things.toml` and `themes.toml`, with plurals. The other words are few and are part
of the grammar, so they stand here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Literal

from scenarios.generation.prompts.vocabulary import phrases, places, plural, things
from scenarios.generation.prompts.wishes import spoken

Kind = Literal[
    "noun",
    "number",
    "option",
    "size",
    "amount",
    "relation",
    "reversed",
    "pronoun",
    "and",
    "with",
    "clause",
    "unknown",
]


@dataclass(frozen=True, slots=True)
class Noun:
    """A thing, a place, or a word that may be either."""

    thing: str = ""
    place: str = ""
    is_weak: bool = False
    """True if a word of another theme says more about the place: a harbour street is a harbour."""
    is_plural: bool = False


# docs/model.md lists these values for users.
OPTIONS: Mapping[tuple[str, object], tuple[str, ...]] = {
    ("density", 1.5): ("crowded", "busy", "dense", "bustling", "lively", "densely furnished"),
    ("density", 1.8): ("very crowded", "very busy", "very dense", "overcrowded", "packed"),
    ("density", 0.6): ("sparse", "empty", "bare", "quiet", "sparsely furnished", "half empty"),
    ("density", 0.4): ("very sparse", "very empty", "almost empty", "nearly empty", "deserted"),
    ("clutter", 3.0): ("cluttered", "messy", "untidy", "chaotic", "with clutter", "clutter"),
    ("clutter", 6.0): ("very cluttered", "very messy", "very untidy"),
    ("difficulty", "easy"): ("easy", "easy to fly", "simple to fly"),
    ("difficulty", "medium"): ("medium difficulty", "moderately difficult"),
    ("difficulty", "hard"): ("hard", "difficult", "hard to fly", "difficult to fly", "tricky"),
    ("domain", "indoor"): ("indoor", "indoors", "interior"),
    ("domain", "outdoor"): ("outdoor", "outdoors", "outside", "open air"),
    ("domain", "mixed"): (
        "mixed",
        "indoor and outdoor",
        "inside and outside",
        "indoors and outdoors",
    ),
}
"""Words that set an option."""
SIZES: Mapping[str, tuple[str, ...]] = {
    "tiny": ("tiny", "very small"),
    "small": ("small", "compact", "little"),
    "large": ("large", "big", "spacious", "extensive"),
    "huge": ("huge", "very large", "very big", "vast", "enormous"),
}
RELATIONS: Mapping[str, tuple[str, ...]] = {
    "on_roof": (
        "on the roof of",
        "on the roofs of",
        "on top of the roof of",
        "on roof of",
        "on the rooftop of",
    ),
    "on": ("on", "on top of", "upon", "atop"),
    "over": ("over", "across", "spanning"),
    "under": ("under", "below", "beneath", "underneath"),
    "inside": ("in", "inside", "within", "inside of"),
    "next_to": ("next to", "beside", "by", "alongside", "adjacent to", "against", "close to", "at"),
    "near": ("near", "nearby", "around here", "in the vicinity of", "not far from"),
    "in_front_of": ("in front of", "before", "outside of"),
    "behind": ("behind", "at the back of", "in back of", "at the rear of"),
    "facing": ("facing", "turned to", "looking at"),
    "between": ("between", "in between"),
    "along": ("along", "lining", "lined up along", "all along"),
    "around": ("around", "surrounding", "all around"),
}
AMOUNTS: Mapping[str, tuple[str, ...]] = {
    "objects": ("objects", "things", "items"),
    "areas": ("landing areas", "landing spots", "landing sites", "landing places", "landing area"),
}
"""Words for the options that are numbers: "150 objects"."""
REVERSED: Mapping[str, tuple[str, ...]] = {
    "around": ("surrounded by", "ringed by", "enclosed by", "framed by"),
    "along": ("lined by", "lined with", "flanked by", "bordered by"),
    "on": ("carrying", "topped with", "topped by"),
    "next_to": ("accompanied by",),
}
"""Words of relations whose host comes first: "a pond surrounded by trees"."""
JOINTS: Mapping[Kind, tuple[str, ...]] = {
    "and": ("and", "or", ",", "as well as", "plus", "&"),
    "with": (
        "with",
        "that has",
        "which has",
        "has",
        "having",
        "containing",
        "contains",
        "including",
        "includes",
    ),
    "pronoun": ("it", "them"),
    "clause": (".", ";", "but", "!", "?", ":", "then"),
}
# fmt: off
FILLERS = frozenset((
    "the", "of", "there", "is", "are", "its", "their", "this", "these", "that", "which",
    "where", "who", "i", "we", "you", "want", "would", "like", "need", "please", "make",
    "create", "generate", "draw", "show", "me", "give", "build", "design", "place", "scene",
    "site", "area", "ground", "world", "environment", "map", "setting", "layout", "parked",
    "standing", "stands", "stand", "placed", "located", "situated", "lying", "lies", "lie",
    "moored", "sitting", "set", "be", "to", "for", "drone", "fly", "one", "can",
    "lined", "consisting", "featuring", "features", "my", "our", "kind", "type",
    "sort", "made", "up", "measuring", "size", "any", "also", "sized",
))
# fmt: on
"""Words that ask for nothing."""


@cache
def lexicon(
    own_themes: frozenset[str] = frozenset(),
) -> Mapping[tuple[str, ...], tuple[Kind, object]]:
    """Return every phrase that the parser knows, as a tuple of words, with kind and meaning.

    Args:
        own_themes: Themes of a checkpoint beside those of the vocabulary, known by their names.
    """
    # Later groups replace earlier ones, so a checkpoint's theme never hides a word of ours.
    found: dict[tuple[str, ...], tuple[Kind, object]] = {
        tuple(spoken(theme).split()): ("noun", Noun(place=theme)) for theme in own_themes
    }
    for words, noun in _nouns().items():
        found[tuple(words.split())] = ("noun", noun)
    for (option, value), group in OPTIONS.items():
        found |= {tuple(words.split()): ("option", (option, value)) for words in group}
    for size, group in SIZES.items():
        found |= {tuple(words.split()): ("size", size) for words in group}
    for relation, group in RELATIONS.items():
        found |= {tuple(words.split()): ("relation", relation) for words in group}
    for option, group in AMOUNTS.items():
        found |= {tuple(words.split()): ("amount", option) for words in group}
    for relation, group in REVERSED.items():
        found |= {tuple(words.split()): ("reversed", relation) for words in group}
    for kind, group in JOINTS.items():
        found |= {tuple(words.split()): (kind, None) for words in group}
    return found


def _nouns() -> dict[str, Noun]:
    found: dict[str, Noun] = {}
    # Things first, because a word for a place may also name a thing, which it then keeps.
    for name, thing in things().items():
        for words, is_plural in phrases(name, thing.words).items():
            found[words] = Noun(thing=name, is_plural=is_plural)
    for theme, place in places().items():
        weak = dict.fromkeys(place.weak, True)
        for words, is_weak in {
            spoken(theme): False,
            **dict.fromkeys(place.words, False),
            **weak,
        }.items():
            thing = place.things.get(words, "")
            own = found.get(words, Noun()).thing
            for each, is_plural in ((plural(words), True), (words, False)):
                found[each] = Noun(thing or own, theme, is_weak, is_plural)
    return found
