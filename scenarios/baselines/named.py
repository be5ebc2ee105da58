"""Pilots by the names that a user gives them."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, cast

if TYPE_CHECKING:
    from scenarios.run.companion import Aboard, Companion

MakePilot = Callable[["Aboard"], "Companion"]
OURS = "demo"
BASELINES = {"straight": "scenarios.baselines.straight_line:StraightLinePilot"}
"""Pilots that ship beside ours, to tell flight stacks apart by."""


class PilotError(ValueError):
    """There is no pilot of a name; one line says why, and what would be valid."""


def pilot_of(text: str, option: str = "pilot") -> MakePilot | None:
    """The pilot that a user names: None is ours, the one of the demo.

    Args:
        text: `demo`, the name of a baseline, or `MODULE:CLASS`; modules are looked for where the
            command was started too.
        option: Name of the option that asks for it, for the message.

    Raises:
        PilotError: If there is no such pilot.
    """
    if text == OURS:
        return None
    names = ", ".join((OURS, *BASELINES))
    valid = f"valid: {names}, or MODULE:CLASS such as my_pilot:Pilot, see docs/python.md"
    module, _, name = BASELINES.get(text, text).partition(":")
    if not module or not name.isidentifier():
        raise PilotError(f"{option} is {text!r}, {valid}")
    if (here := str(Path.cwd())) not in sys.path:
        sys.path.insert(0, here)
    try:
        found = getattr(importlib.import_module(module), name)
    except Exception as error:  # noqa: BLE001 - a user's module may raise anything
        reason = " ".join(str(error).split()) or type(error).__name__
        raise PilotError(f"{option} is {text!r}, but {reason}; {valid}") from None
    if not callable(found):
        raise PilotError(f"{option} is {text!r}, which is no class; {valid}")
    return cast("MakePilot", found)
