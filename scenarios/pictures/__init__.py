"""Pictures of a flight: planned and flown paths over the scene, and the ground of the landing.

A flight that just ended (`tape.FlightTape`) and a recording (`recorded_story.read_story`) both give
a `FlightStory`, and `draw_pictures` draws it. Both sources therefore give the same pictures. Only
this package knows matplotlib.
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
