"""Ranges of scene numbers as a user writes them, such as `0:10,42`."""

from __future__ import annotations

import re

_MOST = 1_000_000
"""Upper limit of the numbers in a text, exclusive; the corpus itself has no end."""
_PART = re.compile("([0-9]{1,7})(?::([0-9]{1,7}))?")


class SceneNumbersError(ValueError):
    """A text does not name any scenes; the message says what would be valid."""


def scene_numbers(text: str) -> tuple[int, ...]:
    """Parse ranges of scene numbers.

    Args:
        text: Parts joined by commas: "0:10" is 0 to 9, "42" is that number alone.

    Returns:
        The numbers in ascending order, each once.

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
