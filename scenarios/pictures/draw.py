"""All pictures of a flight, written into a folder."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from scenarios.pictures.flight import draw_flight
from scenarios.pictures.landing import draw_landing
from scenarios.pictures.story import FlightStory, PictureError

PictureFormat = Literal["png", "svg", "pdf"]
_NAMES = ("flight", "landing")


def draw_pictures(
    story: FlightStory, folder: Path, formats: Sequence[PictureFormat] = ("png",)
) -> list[Path]:
    """Draw `flight`, and `landing` if the pilot looked at a place to land.

    Args:
        story: Flight to draw.
        folder: Folder to write into; it is made if it does not exist.
        formats: Formats of the files: pixels, or lines around renderings.

    Returns:
        The files that were written.

    Raises:
        PictureError: If the files cannot be written.
    """
    flight, landing = ([folder / f"{name}.{kind}" for kind in formats] for name in _NAMES)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        draw_flight(story, flight)
        if story.landing is None:
            return flight
        draw_landing(story, landing)
    except OSError as error:
        raise PictureError(
            f"pictures {str(folder)!r} cannot be written ({error.strerror}); "
            "valid: a folder you may write to"
        ) from None
    return [*flight, *landing]
