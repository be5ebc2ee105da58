"""Hostile files of every kind that a command reads, each with the command that meets it."""

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
    """All of them, kind by kind."""
    for make in _MAKERS.values():
        yield from make()


def cases_of(kind: str) -> Iterator[Case]:
    """Cases of one kind; seconds of work are spared those who want few."""
    yield from _MAKERS[kind]()
