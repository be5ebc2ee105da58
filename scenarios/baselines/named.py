"""Pilots by the names that a user gives them."""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, cast

if TYPE_CHECKING:
    from autonomy.planning import Method
    from scenarios.chat.completions import ChatModel
    from scenarios.run.cfg import SitlCfg
    from scenarios.run.companion import Aboard, Companion

MakePilot = Callable[["Aboard"], "Companion"]
OURS = "demo"
PLANNERS: Mapping[str, Method] = {OURS: "optimise", "mueller": "primitives"}
"""Our pilot's names, and what makes its trajectories under each."""
BASELINES: Mapping[str, str] = {
    "potential": "scenarios.baselines.potential_pilot:PotentialFieldPilot",
    "straight": "scenarios.baselines.straight_line:StraightLinePilot",
    "random": "scenarios.baselines.area_choosers:RANDOM",
    "nearest": "scenarios.baselines.area_choosers:NEAREST",
    "perfect": "scenarios.baselines.area_choosers:PERFECT",
}
"""Classes that ship beside ours, to tell flight stacks apart by."""
VLM = "vlm"
"""Pilot that a vision-language model steers, behind an address that the user names."""
READERS = frozenset(("random", "nearest", "perfect", VLM))
"""Pilots that choose their area by a text, and fly to no other goals."""
SHIPPED = frozenset((*PLANNERS, *BASELINES, VLM))
"""Pilots that need no code but ours."""


class PilotError(ValueError):
    """There is no pilot of a name; one line says why, and what would be valid."""


@dataclass(frozen=True, kw_only=True, slots=True)
class NamedPilot:
    """Who flies: ours by one of its planners, or a class of anybody's."""

    make: MakePilot | None = None
    """Makes the pilot; None is ours."""
    planner: Method = "optimise"
    """What makes our pilot's trajectories."""

    def brief(self, cfg: SitlCfg) -> SitlCfg:
        """The configuration of a run, with this pilot in it as far as it is ours."""
        return replace(cfg, demo=self.make is None, planner=self.planner)


def pilot_of(text: str, option: str = "pilot", chat: ChatModel | None = None) -> NamedPilot:
    """The pilot that a user names.

    Args:
        text: A name that ships, or `MODULE:CLASS`; modules are looked for where the command was
            started too.
        option: Name of the option that asks for it, for the message.
        chat: Model that steers the pilot `vlm`; None for all others.

    Raises:
        PilotError: If there is no such pilot.
    """
    if (text == VLM) != (chat is not None):
        name = "no endpoint" if chat is None else f"endpoint {chat.endpoint!r}"
        raise PilotError(f"{option} is {text!r} with {name}; valid: --pilot vlm --endpoint URL")
    if chat is not None:
        return _steered_by(chat)
    if text in PLANNERS:
        return NamedPilot(planner=PLANNERS[text])
    names = ", ".join((*PLANNERS, *BASELINES, VLM))
    valid = f"valid: {names}, or MODULE:CLASS such as my_pilot:Pilot, see docs/python.md"
    module, _, name = BASELINES.get(text, text).partition(":")
    if not module or not name.isidentifier():
        raise PilotError(f"{option} is {text!r}; {valid}")
    # Only for a module of the user's own: what lies beside a shared folder is not ours to import.
    if text not in BASELINES and (here := str(Path.cwd())) not in sys.path:
        sys.path.insert(0, here)
    try:
        found = getattr(importlib.import_module(module), name)
    except Exception as error:  # noqa: BLE001 - a user's module may raise anything
        reason = " ".join(str(error).split()) or type(error).__name__
        raise PilotError(f"{option} is {text!r}, but {reason}; {valid}") from None
    if not callable(found):
        raise PilotError(f"{option} is {text!r}, which is no class; {valid}")
    return NamedPilot(make=cast("MakePilot", found))


def _steered_by(chat: ChatModel) -> NamedPilot:
    """The pilot that a model steers.

    Raises:
        PilotError: If the address is none.
    """
    from scenarios.baselines.vlm_pilot import VlmPilot
    from scenarios.chat.completions import ChatError

    try:
        _ = chat.address
    except ChatError as error:
        raise PilotError(str(error)) from None
    return NamedPilot(make=partial(VlmPilot, chat, os.environ))
