"""What a scene is and where scenes come from.

The names of `__all__` are the public ones; docs/python.md shows them at work.
"""

from typing import TYPE_CHECKING

from aeroscene.lazy import public_names

if TYPE_CHECKING:
    from aeroscene.areas.landing import derive_interaction_areas
    from aeroscene.learning.generation import Generator, Request, generate_scene
    from aeroscene.scene import InteractionArea, OrientedBox, Scene, SceneError, SceneObject
    from aeroscene.scene.catalogue import CATALOGUE, Category, category_id
    from aeroscene.scene.io import read_scene, write_scene
    from aeroscene.sources import open_scene
    from aeroscene.validation import Finding, validate
    from aeroscene.version import __version__
else:
    __getattr__, __dir__ = public_names(__name__, __file__)

__all__ = [
    "CATALOGUE",
    "Category",
    "Finding",
    "Generator",
    "InteractionArea",
    "OrientedBox",
    "Request",
    "Scene",
    "SceneError",
    "SceneObject",
    "__version__",
    "category_id",
    "derive_interaction_areas",
    "generate_scene",
    "open_scene",
    "read_scene",
    "validate",
    "write_scene",
]
