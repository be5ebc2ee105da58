"""Options that take several values, also when the option is repeated for each value.

tyro reads `--camera A B`. From `--camera A --camera B`, which many programs accept, it would keep
B alone without a warning. `gathered` rewrites the second form as the first.
"""

from __future__ import annotations

from collections.abc import Sequence

_SINGLE = ("--out",)
"""Options that take one value at a time, because the next word may be the scene."""
_GREEDY = ("--camera", "--format")
"""Options that take all values up to the next option."""


def gathered(args: Sequence[str]) -> list[str]:
    """Return the arguments with each repeated option once, at the end, with all of its values.

    For example, `--camera A --speed max --camera B` becomes `--speed max --camera A B`.

    Args:
        args: Words of a command line; they are not changed.
    """
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
        # `--out` without a value gets an empty one. Otherwise it would vanish, and tyro could not
        # refuse it.
        found[name] += values or ([""] if name in _SINGLE else [])
        named.add(name)
    for name, values in found.items():
        rest += [name, *values] if name in named else []
    return rest
