"""Generation of scenes from seeds: program, diffusion, projection.

The names load their modules on first use. A request can therefore be checked at once, without the
seconds that PyTorch takes to load.
"""

from typing import TYPE_CHECKING

from aeroscene.lazy import public_names

if TYPE_CHECKING:
    from aeroscene.feasibility.region import Region
    from aeroscene.learning.generation.generator import (
        Generated,
        Generator,
        NoFeasibleSceneError,
        generate_scene,
    )
    from aeroscene.learning.generation.redo import Redo
    from aeroscene.learning.generation.request import Request
    from aeroscene.learning.wishes import AreaCounts, RequestError
else:
    __getattr__, __dir__ = public_names(__name__, __file__)

__all__ = [
    "AreaCounts",
    "Generated",
    "Generator",
    "NoFeasibleSceneError",
    "Redo",
    "Region",
    "Request",
    "RequestError",
    "generate_scene",
]
