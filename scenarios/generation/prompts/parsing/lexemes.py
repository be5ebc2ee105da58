"""A text as lexemes: at each word, the longest phrase that is known.

The longest phrase wins, because longer phrases are more precise: "on the roof of" is one relation,
and not "on" with a roof.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from scenarios.generation.prompts.parsing.lexicon import FILLERS, Kind, lexicon
from scenarios.generation.prompts.parsing.numbers import number_at

_TOKEN = re.compile(r"\d+|[^\W\d_]+(?:'[^\W\d_]+)?|[.,;:!?&-]")
_LINED = re.compile(r"\b([a-z]+?)s?[ -]lined (street|road|avenue|path|canal|river)\b")
_LONGEST = 5


@dataclass(frozen=True, slots=True)
class Lexeme:
    """A phrase of the prompt with its meaning, which depends on its kind."""

    kind: Kind
    said: str
    value: Any = None


def lexemes(text: str, own_themes: frozenset[str] = frozenset()) -> list[Lexeme]:
    """Split a text into lexemes.

    Args:
        text: Text in lower case, without sizes.
        own_themes: Themes of a checkpoint beside those of the vocabulary.

    Returns:
        Lexemes in order; words that ask for nothing are left out.
    """
    # "tree-lined street" is a relation in one word: the trees are along the street.
    text = _LINED.sub(r"\2 with many \1s along the \2", text)
    tokens = [each for each in _TOKEN.findall(_parted(text)) if each != "'"]
    found, at = [], 0
    while at < len(tokens):
        lexeme, taken = _longest(tokens, at, own_themes)
        if lexeme is not None:
            found.append(lexeme)
        at += taken
    return found


def _parted(text: str) -> str:
    """Return a text with the hyphens within words as spaces; between numbers they stay."""
    return re.sub(r"(?<=[^\W\d])[-\u2010-\u2015](?=[^\W\d])", " ", text)


def _longest(
    tokens: Sequence[str], at: int, own_themes: frozenset[str]
) -> tuple[Lexeme | None, int]:
    known, size = _known(tokens, at, own_themes)
    number = number_at(tokens, at)
    # A longer number wins. A single word that is both counts as the known phrase.
    if number is not None and number[1] >= size and not (known and number[1] == size == 1):
        said = " ".join(tokens[at : at + number[1]])
        return Lexeme("number", said, number[0]), number[1]
    if known is not None:
        return known, size
    word = tokens[at]
    if word in FILLERS or word == "-":
        return None, 1
    return Lexeme("unknown", word), 1


def _known(tokens: Sequence[str], at: int, own_themes: frozenset[str]) -> tuple[Lexeme | None, int]:
    known = lexicon(own_themes)
    for words in _windows(tokens, at):
        if words in known:
            kind, value = known[words]
            return Lexeme(kind, " ".join(words), value), len(words)
    return None, 0


def _windows(tokens: Sequence[str], at: int) -> Iterator[tuple[str, ...]]:
    # The longest window first, so that the first hit is the longest phrase.
    for size in range(min(_LONGEST, len(tokens) - at), 0, -1):
        yield tuple(tokens[at : at + size])
