"""Names of the environments that are registered, and the task of each."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from scenarios.environments.tasks import TASKS

ENVIRONMENTS: Mapping[str, str | None] = MappingProxyType(
    {**{f"AeroScene/{task.capitalize()}-v0": task for task in TASKS}, "AeroScene/Offboard-v0": None}
)
"""Task of each environment; None if it does whichever task it is asked for."""
