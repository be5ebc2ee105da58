"""Numbers in English: `two`, `a pair of`, `at least three`, `5 to 8`, `many`, `no`.

Each becomes a `Number` with a least and a greatest value, because a draw is judged by limits. Bare
numbers from five on are met within a fifth, as numbers of objects are, because the model follows
numbers only roughly. "exactly 20" asks for 20 alone.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from scenarios.generation.prompts.wishes import MOST_COUNT

ABOUT = 0.2
"""Share by which a bare number may be missed, as numbers of objects may."""
# fmt: off
_ONES = [
    "zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten",
    "eleven", "twelve", "thirteen", "fourteen", "fifteen", "sixteen", "seventeen", "eighteen",
    "nineteen",
]
_TENS = [
    "twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety",
]
# fmt: on
_WORDS = {word: n for n, word in enumerate(_ONES)} | {
    word: 10 * n for n, word in enumerate(_TENS, 2)
}


@dataclass(frozen=True, slots=True)
class Number:
    """Limits of a count, and the number that was named."""

    least: int
    most: int | None = None
    n: int | None = None
    is_article: bool = False
    """True for "a" and "an", which ask for no more than that there is one."""
    is_many: bool = False
    """True for "many", whose least value depends on the thing."""


A = Number(1, is_article=True)
NONE = Number(0, 0, 0)
SOME = Number(2)
MANY = Number(10, is_many=True)
_FIXED: dict[tuple[str, ...], Number] = {
    tuple(words.split()): number
    for number, group in (
        (A, ("a", "an", "another")),
        (
            NONE,
            ("no", "not", "without", "without any", "not any", "free of", "zero", "lacking", "nor"),
        ),
        (SOME, ("some", "a number of", "multiple", "more")),
        (Number(3), ("several", "a handful of", "a group of", "various")),
        (Number(2, 5), ("a few", "a small number of")),
        (Number(0, 3), ("few", "very few", "only a few", "just a few")),
        (Number(0, 2), ("hardly any", "scarcely any", "almost no")),
        (Number(1, 1, 1), ("a single", "single", "just one", "only one", "exactly one", "one")),
        (Number(2, 2, 2), ("a pair of", "pair of", "a couple of", "couple of", "two", "both")),
        (MANY, ("many", "lots of", "a lot of", "plenty of", "numerous", "loads of", "countless")),
        (MANY, ("full of", "filled with", "packed with", "crowded with", "a large number of")),
        (Number(24), ("dozens of",)),
    )
    for words in group
}
_LIMITS = {
    ("at", "least"): "least",
    ("no", "fewer", "than"): "least",
    ("no", "less", "than"): "least",
    ("a", "minimum", "of"): "least",
    ("more", "than"): "above",
    ("over",): "above",
    ("at", "most"): "most",
    ("no", "more", "than"): "most",
    ("up", "to"): "most",
    ("a", "maximum", "of"): "most",
    ("fewer", "than"): "below",
    ("less", "than"): "below",
    ("exactly",): "just",
    ("precisely",): "just",
    ("just",): "just",
    ("only",): "just",
    ("about",): "about",
    ("around",): "about",
    ("roughly",): "about",
    ("approximately",): "about",
    ("some",): "about",
    ("nearly",): "about",
    ("almost",): "about",
}
_LONGEST = 4


def number_at(tokens: Sequence[str], at: int) -> tuple[Number, int] | None:
    """Read the number that begins at a token.

    Args:
        tokens: Tokens of the text, in lower case.
        at: Index of the first token.

    Returns:
        The number and how many tokens it takes, or None if no number begins there.
    """
    # Limits before fixed words: "some 20 cars" is about 20, but "some cars" is two or more.
    for size in range(_LONGEST, 0, -1):
        words = tuple(tokens[at : at + size])
        if len(words) == size and words in _LIMITS and (found := _whole(tokens, at + size)):
            n, taken = found
            return _limited(_LIMITS[words], n), size + taken
    if (spread := _spread(tokens, at)) is not None:
        return spread
    fixed = _fixed(tokens, at)
    whole = _whole(tokens, at)
    if whole is not None and (fixed is None or whole[1] > fixed[1]):
        return about(whole[0]), whole[1]
    return fixed


def about(n: int) -> Number:
    """Return the limits of a bare number: exact below five, within a fifth from five on.

    Args:
        n: The number; 20 gives 16 to 24.
    """
    # Rounding inwards makes the limits of numbers below five the number itself.
    most = math.floor((1 + ABOUT) * n)
    return Number(math.ceil((1 - ABOUT) * n), max(n, min(most, MOST_COUNT)), n)


def _limited(limit: str, n: int) -> Number:
    if limit == "least":
        return Number(n, None, n)
    if limit == "above":
        return Number(n + 1, None, n)
    if limit == "most":
        return Number(0, n, n)
    if limit == "below":
        return Number(0, max(0, n - 1), n)
    return Number(n, n, n) if limit == "just" else about(n)


def _fixed(tokens: Sequence[str], at: int) -> tuple[Number, int] | None:
    for size in range(_LONGEST, 0, -1):
        words = tuple(tokens[at : at + size])
        if len(words) == size and words in _FIXED:
            return _FIXED[words], size
    return None


def _spread(tokens: Sequence[str], at: int) -> tuple[Number, int] | None:
    """Read "5 to 8", "5 - 8", "between 5 and 8" or "five or six"; None if there is none."""
    skip = 1 if tokens[at] in {"between", "from"} else 0
    first = _whole(tokens, at + skip)
    if first is None:
        return None
    low, taken = first
    middle = at + skip + taken
    # "two and three" alone are two numbers of two things.
    joints = {"and"} if tokens[at] == "between" else {"to", "-", "or"}
    if middle >= len(tokens) or tokens[middle] not in joints:
        return None
    second = _whole(tokens, middle + 1)
    if second is None:
        return None
    high, more = second
    return Number(low, high, high), skip + taken + 1 + more


def _whole(tokens: Sequence[str], at: int) -> tuple[int, int] | None:
    """Return a whole number and how many tokens it takes, None if there is none."""
    words = list(tokens[at : at + 3])
    if not words:
        return None
    if words[0].isdecimal():
        # The first nine digits already exceed every range.
        n, taken = int(words[0][:9]), 1
    elif words[0] == "half" and words[1:] == ["a", "dozen"]:
        return 6, 3
    elif words[0] in {"a", "one"} and words[1:2] in (["dozen"], ["hundred"]):
        return (12 if words[1] == "dozen" else 100), 2
    elif words[0] in _WORDS:
        n, taken = _WORDS[words[0]], 1
        ones = _WORDS.get(words[1], 0) if len(words) > 1 else 0
        if words[0] in _TENS and 0 < ones < 10:
            n, taken = n + ones, 2
    else:
        return None
    # "two dozen", "three hundred"
    after = tokens[at + taken : at + taken + 1]
    if after in (["dozen"], ["hundred"]):
        return n * (12 if after == ["dozen"] else 100), taken + 1
    return n, taken
