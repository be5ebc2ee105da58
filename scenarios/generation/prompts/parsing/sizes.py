"""Sizes of sites in words: `80 by 60 m`, `half a hectare`, `doors at least 1.2 m wide`.

Regular expressions read these, because sizes have a fixed form, and their words ("by", "x", "m")
would confuse the parser. What they match is cut out of the text before the parser sees it.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field

from scenarios.generation.prompts.wishes import PromptError, Reading

_ABOUT = r"(?:\b(?:about|around|roughly|approximately|some) )?"
_NUMBER = r"(\d{1,6}(?:\.\d{1,3})?)"
_METRES = r"(?:m|metres?|meters?)"
_SIDES = re.compile(
    rf"{_ABOUT}{_NUMBER}\s*{_METRES}?\s*(?:by|x|×)\s*{_NUMBER}\s*{_METRES}?\b(?:\s+wide)?"
)
_HECTARES = re.compile(
    rf"{_ABOUT}(?:{_NUMBER}|half an?|(?:a )?quarter of an?|one|two|an?)\s*(?:hectares?|ha)\b"
)
_SQUARE_METRES = re.compile(
    rf"{_ABOUT}{_NUMBER}\s*(?:square {_METRES}|sq\.? ?m|m2|m²|{_METRES} squared)(?!\w)"
)
_PASSAGES = re.compile(
    r"\b(?:doors?|doorways?|corridors?|passages?)(?: (?:and|or) (?:doors|corridors|passages))?"
    rf"[a-z ]{{0,20}}?at least {_NUMBER}\s*{_METRES}\b(?: wide)?"
)
_OF_HECTARE = {"half": 0.5, "quarter": 0.25, "a quarter": 0.25, "one": 1.0, "two": 2.0, "a": 1.0}
_M2 = 10_000.0


@dataclass
class Sizes:
    """Lengths that a prompt names, and the text without them."""

    text: str
    outline_m: tuple[float, float] | None = None
    min_passage_m: float | None = None
    readings: list[Reading] = field(default_factory=list)


def without_sizes(text: str) -> Sizes:
    """Take the sizes out of a text.

    Args:
        text: Text in lower case.

    Returns:
        Sizes, and the text without their words.

    Raises:
        PromptError: If it names two sizes of the site.
    """
    found = Sizes(text)
    if match := _PASSAGES.search(found.text):
        found.min_passage_m = float(match[1])
        _take(found, match, "min_passage")
    for pattern in (_SIDES, _SQUARE_METRES, _HECTARES):
        while match := pattern.search(found.text):
            sides_m = _sides_m(pattern, match)
            if found.outline_m not in {None, sides_m}:
                said = [each.said for each in found.readings if each.option == "outline"]
                raise PromptError(
                    f"prompt asks for the sizes {said[0]!r} and {match[0].strip()!r}; "
                    "valid: one of the two"
                )
            found.outline_m = sides_m
            _take(found, match, "outline")
    return found


def _sides_m(pattern: re.Pattern[str], match: re.Match[str]) -> tuple[float, float]:
    if pattern is _SIDES:
        return float(match[1]), float(match[2])
    if match[1] is not None:
        area_m2 = float(match[1]) * (1.0 if pattern is _SQUARE_METRES else _M2)
    else:
        said = re.sub(f"^{_ABOUT}", "", match[0])
        words = re.sub(r"\s*(?:of )?(?:an?)?\s*(?:hectares?|ha)$", "", said).strip() or "a"
        area_m2 = _OF_HECTARE[words] * _M2
    # An area says nothing of the sides, so the site is a square.
    side_m = round(math.sqrt(area_m2), 1)
    return side_m, side_m


def _take(found: Sizes, match: re.Match[str], option: str) -> None:
    found.readings.append(Reading(option, match[0].strip()))
    found.text = f"{found.text[: match.start()]} {found.text[match.end() :]}"
