"""Small scenes of a few things on open ground."""

from dataclasses import replace

from aeroscene.corpus.field import field_scene
from aeroscene.scene import OrientedBox, SceneObject
from aeroscene.scene.catalogue import by_name

BENCH = (0.5, 1.6, 0.5)


def thing(number, category, place, size, *, z=0.0, **attributes):
    """An object that stands on the ground, or at a height."""
    x, y = place
    return SceneObject(
        id=number,
        scene_id="car park",
        parent_id=None,
        category_id=by_name()[category].id,
        bbox=OrientedBox((x, y, z + size[2] / 2), (1.0, 0.0, 0.0, 0.0), size),
        domain="outdoor",
        attributes=attributes,
    )


def car(number, colour, place):
    """A car that is 4 m long, with its nose to the east."""
    return thing(number, "car", place, (4.0, 1.8, 1.5), colour=colour)


def scene_of(*objects):
    """A scene of some objects alone."""
    return replace(field_scene(), scene_id="car park", objects=objects, interaction_areas=())
