"""Tasks: the beginning of an episode, its reward, and its end."""

from collections.abc import Mapping
from types import MappingProxyType

from scenarios.environments.cfg import EnvironmentInputError
from scenarios.environments.tasks.hover import Hover
from scenarios.environments.tasks.landing import Landing
from scenarios.environments.tasks.navigation import Navigation
from scenarios.environments.tasks.situation import Situation
from scenarios.environments.tasks.task import Start, Task

TASKS: Mapping[str, type[Task]] = MappingProxyType(
    {task.name: task for task in (Hover, Navigation, Landing)}
)
"""Tasks of one vehicle by their names."""

__all__ = ["TASKS", "Hover", "Landing", "Navigation", "Situation", "Start", "Task", "task_by_name"]


def task_by_name(name: str) -> Task:
    """Return the task of one vehicle.

    Raises:
        EnvironmentInputError: If there is none of that name.
    """
    if name not in TASKS:
        raise EnvironmentInputError(f"task = {name!r}: {', '.join(TASKS)} are valid")
    return TASKS[name]()
