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

from scenarios.environments.tasks import TASKS

__all__ = ["make", "make_vec", "register_environments"]


def register_environments() -> None:
    """Register every task; importing `scenarios.environments` does it.

    A second call changes nothing.
    """
    for task in TASKS:
        name = f"AeroScene/{task.capitalize()}-v0"
        if name not in gymnasium.registry:
            gymnasium.register(
                id=name,
                entry_point="scenarios.environments.single:AeroSceneEnv",
                vector_entry_point="scenarios.environments.vector:AeroSceneVectorEnv",
                kwargs={"task": task},
            )
