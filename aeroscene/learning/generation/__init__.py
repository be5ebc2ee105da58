"""Generation of a scene from a seed: a program, its diffusion, feasibility."""

from aeroscene.learning.generation.generator import (
    Generated,
    Generator,
    NoFeasibleSceneError,
    generate_scene,
)
from aeroscene.learning.generation.request import Request, RequestError

__all__ = [
    "Generated",
    "Generator",
    "NoFeasibleSceneError",
    "Request",
    "RequestError",
    "generate_scene",
]
