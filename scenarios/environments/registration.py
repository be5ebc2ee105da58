"""Names by which Gymnasium makes the environments."""

from __future__ import annotations

try:
    import gymnasium
    from gymnasium import make, make_vec
except ModuleNotFoundError as error:
    raise ModuleNotFoundError(
        "the environments need gymnasium, which is not installed; pip install 'aeroscene[rl]'",
        name="gymnasium",
    ) from error

from scenarios.environments.autopilots import AutopilotCfg
from scenarios.environments.names import ENVIRONMENTS

__all__ = ["make", "make_vec", "register_environments"]


def register_environments() -> None:
    """Register every task; importing `scenarios.environments` does it.

    A second call changes nothing.
    """
    for name, task in ENVIRONMENTS.items():
        if name not in gymnasium.registry:
            gymnasium.register(
                id=name,
                entry_point="scenarios.environments.single:AeroSceneEnv",
                vector_entry_point="scenarios.environments.vector:AeroSceneVectorEnv",
                kwargs={"task": task}
                if task is not None
                else {"task": "hover", "autopilot": AutopilotCfg()},
            )
