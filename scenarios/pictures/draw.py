"""All pictures of a flight, into a folder."""

from __future__ import annotations

from pathlib import Path

from scenarios.pictures.flight import draw_flight
from scenarios.pictures.landing import draw_landing
from scenarios.pictures.story import FlightStory, PictureError

FLIGHT, LANDING = "flight.png", "landing.png"


def draw_pictures(story: FlightStory, folder: Path) -> list[Path]:
    """Draw `flight.png`, and `landing.png` if the pilot looked at a place to land.

    Args:
        story: What to draw.
        folder: Where to; it is made if it does not exist.

    Returns:
        The files that were written.

    Raises:
        PictureError: If they cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        draw_flight(story, folder / FLIGHT)
        if story.landing is None:
            return [folder / FLIGHT]
        draw_landing(story, folder / LANDING)
    except OSError as error:
        raise PictureError(
            f"pictures {str(folder)!r} cannot be written ({error.strerror}); "
            "valid: a folder you may write to"
        ) from None
    return [folder / FLIGHT, folder / LANDING]
