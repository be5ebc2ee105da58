"""Hostile files of every kind that a command reads, each with the command that meets it.

A case is a rule that was broken once or could be: an extreme value, a name with control characters,
a file that claims to be large, text that nests without end, or code that a folder names.
"""

from collections.abc import Iterator

from fuzzing.files.campaigns import campaign_cases
from fuzzing.files.case import Case
from fuzzing.files.layouts import layout_cases
from fuzzing.files.recordings import recording_cases
from fuzzing.files.scenes import scene_cases
from fuzzing.files.settings import settings_cases
from fuzzing.files.vehicles import vehicle_cases
from fuzzing.files.weights import weight_cases

__all__ = ["Case", "all_cases", "cases_of"]


_MAKERS = {
    "scene": scene_cases,
    "layout": layout_cases,
    "airframe": vehicle_cases,
    "settings": settings_cases,
    "campaign": campaign_cases,
    "recording": recording_cases,
    "checkpoint": weight_cases,
}


def all_cases() -> Iterator[Case]:
    """Every case of every kind, kind by kind."""
    for make in _MAKERS.values():
        yield from make()


def cases_of(kind: str) -> Iterator[Case]:
    """Cases of one kind; the other kinds, which take seconds to make, are not made.

    Args:
        kind: A key of `_MAKERS`.

    Raises:
        KeyError: If there is no such kind.
    """
    yield from _MAKERS[kind]()
