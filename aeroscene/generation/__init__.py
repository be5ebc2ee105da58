"""From a seed to a scene: skeleton, guided diffusion, feasibility."""

from aeroscene.generation.generator import (
    Generated,
    Generator,
    NoFeasibleSceneError,
    generate_scene,
)
from aeroscene.generation.request import Request, RequestError

__all__ = [
    "Generated",
    "Generator",
    "NoFeasibleSceneError",
    "Request",
    "RequestError",
    "generate_scene",
]
