"""Text from files that cannot act on a terminal: control characters become visible escapes."""

from __future__ import annotations

import unicodedata

_HIDDEN = frozenset(("Cc", "Cf", "Cs", "Zl", "Zp"))
"""Control, format (such as a change of writing direction), surrogate, line and paragraph ends."""


_SHOWN = 200
"""Characters of a value that a message shows."""


def visible(text: str) -> str:
    """The text with every character that a terminal would obey, or not show, as an escape.

    A name such as `ESC ]0;title BEL` would otherwise set the title of the user's window, and one
    with a change of writing direction would show another name than it is.
    """
    if text.isascii() and text.isprintable():
        return text
    return "".join(_escaped(each) if _is_hidden(each) else each for each in text)


def is_visible(text: str) -> bool:
    """Whether `visible` would leave the text as it is."""
    return (text.isascii() and text.isprintable()) or not any(map(_is_hidden, text))


def shown(value: object, most: int = _SHOWN) -> str:
    """A value as a message shows it: on one line and not endless."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # An integer or a nesting beyond Python's own limits.
        text = f"a {type(value).__name__} too long to show"
    return text if len(text) <= most else f"{text[:most]}..."


def _is_hidden(character: str) -> bool:
    return unicodedata.category(character) in _HIDDEN


def _escaped(character: str) -> str:
    return character.encode("unicode_escape").decode("ascii")
