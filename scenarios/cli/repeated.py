"""Options that take several values, named once for each of them.

tyro takes `--camera A B`. Of `--camera A --camera B` it would keep B alone, without a word.
"""

from __future__ import annotations

from collections.abc import Sequence

_SINGLE = ("--out",)
"""Options of one value each time, so that what follows is free for a scene."""
_GREEDY = ("--camera", "--format")
"""Options of all values up to the next option."""


def gathered(args: Sequence[str]) -> list[str]:
    """The arguments with all values of a repeated option behind its one, last occurrence."""
    rest, named, found = [], set[str](), {name: [] for name in (*_SINGLE, *_GREEDY)}
    waiting = list(args)
    while waiting:
        word = waiting.pop(0)
        name, equals, value = word.partition("=")
        if name not in found:
            rest.append(word)
            continue
        values = [value] if equals else []
        while waiting and not waiting[0].startswith("-"):
            if values and name in _SINGLE:
                break
            values.append(waiting.pop(0))
        # An option of one value that has none must not pass as one that is not there.
        found[name] += values or ([""] if name in _SINGLE else [])
        named.add(name)
    for name, values in found.items():
        rest += [name, *values] if name in named else []
    return rest
