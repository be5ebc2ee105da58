"""Generation of a scene from a seed: a program, its diffusion, feasibility."""

# ruff: noqa: E402 - a missing torch is reported in our words before an import below fails on it.
from aeroscene.learning import require_torch

require_torch()

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
