"""Pilots by the names with which a user asks for them."""

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
"""Our pilot's names, and its method of planning under each."""
BASELINES: Mapping[str, str] = {
    "potential": "scenarios.baselines.potential_pilot:PotentialFieldPilot",
    "straight": "scenarios.baselines.straight_line:StraightLinePilot",
    "random": "scenarios.baselines.area_choosers:RANDOM",
    "nearest": "scenarios.baselines.area_choosers:NEAREST",
    "perfect": "scenarios.baselines.area_choosers:PERFECT",
}
"""Baselines that ship, as MODULE:CLASS, so that only the one that flies is imported."""
POLICY = "policy:"
"""Beginning of a pilot's name that is followed by the file of a learnt policy."""
VLM = "vlm"
"""Pilot that a vision-language model steers, behind an address that the user names."""
READERS = frozenset(("random", "nearest", "perfect", VLM))
"""Pilots that choose their area by a text, and cannot fly to other goals."""
SHIPPED = frozenset((*PLANNERS, *BASELINES, VLM))
"""Pilots that need no code of the user's."""


class PilotError(ValueError):
    """There is no pilot of a name; the message says why, and what would be valid."""


@dataclass(frozen=True, kw_only=True, slots=True)
class NamedPilot:
    """A pilot that a user has named: ours with one of its planners, or any class."""

    make: MakePilot | None = None
    """Function or class that makes the pilot; None is ours."""
    planner: Method = "optimise"
    """Method by which our pilot plans trajectories."""

    def brief(self, cfg: SitlCfg) -> SitlCfg:
        """Return a run's configuration that asks for our pilot and its planner, if this is ours.

        Args:
            cfg: Configuration of the run.
        """
        return replace(cfg, demo=self.make is None, planner=self.planner)


def pilot_of(text: str, option: str = "pilot", chat: ChatModel | None = None) -> NamedPilot:
    """Return the pilot that a user names.

    Args:
        text: A name that ships, `policy:FILE`, or `MODULE:CLASS`. Modules are also searched for in
            the folder in which the command was started.
        option: Name of the option that asks for it, for the message.
        chat: Model that steers the pilot `vlm`; None for all others.

    Raises:
        PilotError: If there is no such pilot.
    """
    # A model without the pilot is refused too, because it would be ignored silently.
    if (text == VLM) != (chat is not None):
        name = "no endpoint" if chat is None else f"endpoint {chat.endpoint!r}"
        raise PilotError(f"{option} is {text!r} with {name}; valid: --pilot vlm --endpoint URL")
    if chat is not None:
        return _steered_by(chat)
    if text.startswith(POLICY):
        return _learnt(Path(text.removeprefix(POLICY)), option, text)
    if text in PLANNERS:
        return NamedPilot(planner=PLANNERS[text])
    names = ", ".join((*PLANNERS, *BASELINES, VLM))
    valid = (
        f"valid: {names}, policy:FILE, or MODULE:CLASS such as my_pilot:Pilot, see docs/python.md"
    )
    module, _, name = BASELINES.get(text, text).partition(":")
    if not module or not name.isidentifier():
        raise PilotError(f"{option} is {text!r}; {valid}")
    # Only for a module of the user's own. For a baseline, a file of the same name in a shared
    # folder must not be imported.
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


def _learnt(path: Path, option: str, text: str) -> NamedPilot:
    """Return the pilot that a learnt policy flies.

    Raises:
        PilotError: If the file cannot be used, or the extra `rl` is not installed.
    """
    try:
        from scenarios.baselines.policy_pilot import PolicyMaker
        from scenarios.policies.description import PolicyError
        from scenarios.policies.policy import read_policy
    except ModuleNotFoundError as error:
        raise PilotError(
            f"{option} is {text!r}, which needs {error.name}; pip install 'aeroscene[rl]'"
        ) from None
    try:
        return NamedPilot(make=PolicyMaker(read_policy(path)))
    except PolicyError as error:
        raise PilotError(f"{option} is {text!r}, but {error}") from None


def _steered_by(chat: ChatModel) -> NamedPilot:
    """Return the pilot that a model steers.

    Raises:
        PilotError: If the model's address is malformed.
    """
    from scenarios.baselines.vlm_pilot import VlmPilot
    from scenarios.chat.completions import ChatError

    try:
        _ = chat.address
    except ChatError as error:
        raise PilotError(str(error)) from None
    return NamedPilot(make=partial(VlmPilot, chat, os.environ))
