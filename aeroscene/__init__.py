"""The door to AeroScene: `import aeroscene` offers every public name, loaded at its first use.

The names come from the packages that define them: scenes from here, simulation from `flightsim`,
and runs, pilots, recordings and environments from `scenarios`. docs/python.md shows them at work.
"""

from typing import TYPE_CHECKING

from aeroscene.lazy import public_names

if TYPE_CHECKING:
    from aeroscene.areas.landing import derive_interaction_areas
    from aeroscene.learning.generation import Generator, Request, generate_scene
    from aeroscene.scene import InteractionArea, OrientedBox, Scene, SceneError, SceneObject
    from aeroscene.scene.catalogue import CATALOGUE, Category, category_id
    from aeroscene.scene.io import read_scene, write_scene
    from aeroscene.sources import load_scene
    from aeroscene.validation import Finding, validate
    from aeroscene.version import __version__
    from flightsim import *  # noqa: F403 - the names are those of its `__all__`
    from scenarios import *  # noqa: F403

    __all__ = [  # of this package alone; at run time the names of all three
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
        "load_scene",
        "read_scene",
        "validate",
        "write_scene",
    ]
else:
    __getattr__, __dir__ = public_names(__name__, __file__)
