"""Text from files that cannot act on a terminal: control characters become visible escapes."""

from __future__ import annotations

import unicodedata

_HIDDEN = frozenset(("Cc", "Cf", "Cs", "Zl", "Zp"))
"""Control, format (such as a change of writing direction), surrogate, line and paragraph ends."""


_SHOWN = 200
"""Most characters of a value in a message."""


def visible(text: str) -> str:
    """Replace every character that a terminal would obey, or not show, by an escape.

    A name such as `ESC ]0;title BEL` would otherwise set the title of the user's window. A name
    with a change of writing direction would look like another name.
    """
    if text.isascii() and text.isprintable():
        return text
    return "".join(_escaped(each) if _is_hidden(each) else each for each in text)


def is_visible(text: str) -> bool:
    """Return true if `visible` would leave the text as it is."""
    return (text.isascii() and text.isprintable()) or not any(map(_is_hidden, text))


def shown(value: object, most: int = _SHOWN) -> str:
    """Text of a value for a message: on one line and not endless.

    Args:
        value: Any value.
        most: Most characters, without the dots of a cut.
    """
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # An integer or a nesting beyond Python's own limits.
        text = f"a {type(value).__name__} too long to show"
    return text if len(text) <= most else f"{text[:most]}..."


def _is_hidden(character: str) -> bool:
    return unicodedata.category(character) in _HIDDEN


def _escaped(character: str) -> str:
    return character.encode("unicode_escape").decode("ascii")
