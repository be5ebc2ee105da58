"""Pictures of a flight: what was planned and flown over the scene, and the ground it landed on.

Of a flight that just ended (`tape.FlightTape`) or of a recording (`recorded.read_story`): both give
a `FlightStory`, and `draw_pictures` draws it. Only this package knows matplotlib.
"""

from typing import TYPE_CHECKING

from aeroscene.lazy import public_names

if TYPE_CHECKING:
    from scenarios.pictures.draw import PictureFormat, draw_pictures
    from scenarios.pictures.story import FlightStory, PictureError
else:
    # A recording is read, and perhaps refused, before matplotlib is loaded.
    __getattr__, __dir__ = public_names(__name__, __file__)

__all__ = ["FlightStory", "PictureError", "PictureFormat", "draw_pictures"]
