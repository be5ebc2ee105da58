"""The prompt of `aeroscene generate`: read once, joined with the options, and printed."""

from __future__ import annotations

import os
from dataclasses import Field, fields, replace
from typing import Any, ClassVar, Protocol, TypeVar

from scenarios.cli.terminal import styled, terminal
from scenarios.generation.prompts.parsing import read_prompt
from scenarios.generation.prompts.understanding import Themes, Understanding, understood
from scenarios.generation.prompts.wishes import PromptError, Wishes
from scenarios.generation.text_options import GenerateError

_BESIDE = (
    "domain",
    "theme",
    "objects",
    "areas",
    "density",
    "clutter",
    "min_passage",
    "difficulty",
    "outline",
    "complete",
    "redo",
)
"""Options that a prompt may set, or that limit what it may set."""


class _Options(Protocol):
    """Dataclass of options that has a prompt among them."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    @property
    def prompt(self) -> str: ...
    @property
    def prompt_endpoint(self) -> str: ...
    @property
    def prompt_model(self) -> str: ...


_Cfg = TypeVar("_Cfg", bound=_Options)


def prompt_wishes(cfg: _Options, own_themes: frozenset[str]) -> Wishes:
    """Read the prompt, by a parser or by the endpoint that the options name.

    This works before the model is loaded, so that a bad prompt is refused at once.

    Args:
        cfg: Options of the command.
        own_themes: Themes of the user's own checkpoint, which the prompt may name.

    Returns:
        The wishes; an empty collection without a prompt.

    Raises:
        SceneError: If it contradicts itself, is not understood, or the endpoint is of no use.
    """
    if cfg.prompt_endpoint and not cfg.prompt:
        raise GenerateError(
            f"prompt-endpoint is {cfg.prompt_endpoint!r} without --prompt; valid: the two together"
        )
    if not cfg.prompt_endpoint and cfg.prompt_model != "default":
        raise GenerateError(
            f"prompt-model is {cfg.prompt_model!r} without --prompt-endpoint; "
            "valid: the two together"
        )
    if not cfg.prompt:
        return Wishes()
    if cfg.prompt_endpoint:
        # Sockets and TLS: only where somebody asks for them.
        from scenarios.generation.prompts.endpoint import ask_endpoint

        wishes = ask_endpoint(
            cfg.prompt, cfg.prompt_endpoint, cfg.prompt_model, os.environ, own_themes=own_themes
        )
    else:
        wishes = read_prompt(cfg.prompt, own_themes)
    if wishes.is_empty:
        raise PromptError(
            f"prompt {cfg.prompt[:200]!r} has no wish that is understood; valid: English words for "
            "a place and what is there, such as 'a park with two benches'"
        )
    return wishes


def prompted(
    cfg: _Cfg, wishes: Wishes, themes: Themes | None = None
) -> tuple[_Cfg, Understanding | None]:
    """Fill options from the prompt, and report what was understood.

    Args:
        cfg: Options as they were given.
        wishes: Wishes that were read from the prompt.
        themes: Themes that the checkpoint knows; None while it is not loaded.

    Returns:
        Options with the wishes filled in, except those that the user set; and the report, None
        without a prompt.
    """
    if not cfg.prompt:
        return cfg, None
    defaults = {each.name: each.default for each in fields(cfg)}
    # An option that equals its default counts as not given, so the prompt may set it.
    given = {name: getattr(cfg, name) for name in _BESIDE if getattr(cfg, name) != defaults[name]}
    found = understood(cfg.prompt, wishes, given, themes)
    return replace(cfg, **found.options), found


def print_understood(found: Understanding) -> None:
    """Print one line for each wish, each note, and the words that were not understood."""
    console = terminal()
    wide = max((len(said) for said, _ in found.rows), default=0)
    console.print("understood")
    for said, wish in found.rows:
        console.print(f"  {said:{min(wide, 40)}}  {wish}", soft_wrap=True)
    for note in found.notes:
        console.print(f"  note: {note}", soft_wrap=True)
    if found.not_understood:
        words = ", ".join(found.not_understood)
        console.print(styled(("not understood", "bold red"), f": {words}"), soft_wrap=True)
