"""Generation of a scene from a seed: a program, its diffusion, feasibility."""

from aeroscene.feasibility.region import Region
from aeroscene.learning.generation.asked import AreaCounts, RequestError
from aeroscene.learning.generation.generator import (
    Generated,
    Generator,
    NoFeasibleSceneError,
    generate_scene,
)
from aeroscene.learning.generation.redo import Redo
from aeroscene.learning.generation.request import Request

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
