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

__all__ = ["Case", "all_cases"]


def all_cases() -> Iterator[Case]:
    """All of them, kind by kind."""
    yield from scene_cases()
    yield from layout_cases()
    yield from vehicle_cases()
    yield from settings_cases()
    yield from campaign_cases()
    yield from recording_cases()
    yield from weight_cases()
