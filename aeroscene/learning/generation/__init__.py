"""Generation of a scene from a seed: a program, its diffusion, feasibility."""

from aeroscene.learning.generation.generator import (
    Generated,
    Generator,
    NoFeasibleSceneError,
    generate_scene,
)
from aeroscene.learning.generation.request import AreaCounts, Request, RequestError

__all__ = [
    "AreaCounts",
    "Generated",
    "Generator",
    "NoFeasibleSceneError",
    "Request",
    "RequestError",
    "generate_scene",
]
