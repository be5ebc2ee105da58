"""Ranges of scene numbers, as a user writes them."""

from __future__ import annotations

import re

_MOST = 1_000_000
"""Numbers that are written one by one or as a range; the corpus itself has no end."""
_PART = re.compile("([0-9]{1,7})(?::([0-9]{1,7}))?")


class SceneNumbersError(ValueError):
    """A text that names no scenes."""


def scene_numbers(text: str) -> tuple[int, ...]:
    """Parse ranges into numbers in ascending order: "0:10" is 0 to 9, "42" itself, commas join.

    Raises:
        SceneNumbersError: If a part is malformed, empty or reaches beyond 999,999.
    """
    numbers: set[int] = set()
    for part in text.split(","):
        match = _PART.fullmatch(part)
        first, end = (int(match[1]), int(match[2] or int(match[1]) + 1)) if match else (0, 0)
        if not first < end <= _MOST:
            raise SceneNumbersError(
                f"scenes {part!r} is no range of scenes; valid: A:B, A up to and without B, or "
                f"single numbers, from 0 to {_MOST - 1}, joined by commas"
            )
        numbers.update(range(first, end))
    return tuple(sorted(numbers))
