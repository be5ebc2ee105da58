"""Gymnasium environments in which policies learn to fly; see docs/learning.md.

Importing this package registers `AeroScene/Hover-v0`, `AeroScene/Navigation-v0`,
`AeroScene/Landing-v0` and `AeroScene/Offboard-v0`. It needs the extra `rl`.
"""

from scenarios.environments.autopilots import AutopilotCfg
from scenarios.environments.cfg import (
    EnvironmentCfg,
    EnvironmentInputError,
    ObservationCfg,
    RandomisationCfg,
)
from scenarios.environments.registration import make, make_vec, register_environments
from scenarios.environments.single import AeroSceneEnv
from scenarios.environments.vector import AeroSceneVectorEnv

__all__ = [
    "AeroSceneEnv",
    "AeroSceneVectorEnv",
    "AutopilotCfg",
    "EnvironmentCfg",
    "EnvironmentInputError",
    "ObservationCfg",
    "RandomisationCfg",
    "make",
    "make_vec",
    "register_environments",
]

register_environments()
