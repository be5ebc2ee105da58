"""Tasks: how an episode begins, what is rewarded, and when it is over."""

from collections.abc import Mapping
from types import MappingProxyType

from scenarios.environments.tasks.hover import Hover
from scenarios.environments.tasks.landing import Landing
from scenarios.environments.tasks.navigation import Navigation
from scenarios.environments.tasks.task import Situation, Start, Task

TASKS: Mapping[str, type[Task]] = MappingProxyType(
    {"hover": Hover, "navigation": Navigation, "landing": Landing}
)
"""Tasks by their names."""

__all__ = ["TASKS", "Hover", "Landing", "Navigation", "Situation", "Start", "Task"]
