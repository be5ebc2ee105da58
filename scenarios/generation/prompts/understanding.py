"""Options that follow from a prompt, given the user's options and the themes of a checkpoint.

Three sources may speak of one option. The user's own options win over the prompt, and a checkpoint
can only draw the themes of its corpus. Every change is noted in a line that the user reads, because
a wish that is dropped silently looks like a fault of the model.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import msgspec

from aeroscene.files.visible import visible
from scenarios.generation.prompts.vocabulary import domains_of, places, things
from scenarios.generation.prompts.wishes import Wishes, named, spoken

Themes = Mapping[Any, Collection[str]]
"""Themes that a checkpoint knows, by domain."""
_OPTIONS = (
    "domain",
    "theme",
    "objects",
    "areas",
    "density",
    "clutter",
    "min_passage",
    "difficulty",
)
_EXCLUDED = {"objects": "density", "density": "objects"}
"""Options that exclude each other: both decide on the number of objects."""


@dataclass(frozen=True, kw_only=True)
class Understanding:
    """A prompt as it was understood, with the options that follow from it."""

    prompt: str
    wishes: Wishes
    options: Mapping[str, Any]
    """Options of `aeroscene generate` that follow from it, by their names."""
    notes: tuple[str, ...] = ()
    """Changes and additions with their reasons, a line each."""

    @property
    def rows(self) -> list[tuple[str, str]]:
        """Words of the prompt, each with the wish that they became."""
        said = {each.option: each.said for each in self.wishes.readings}
        options = [
            (said.get(name, ""), f"{spoken(name)}: {value}") for name, value in self.options.items()
        ]
        demands = [(each.said, f"{each.title}: {each.number}") for each in self.wishes.demands]
        return [(visible(words), wish) for words, wish in (*options, *demands)]

    @property
    def not_understood(self) -> tuple[str, ...]:
        """Words that became no wish."""
        return tuple(map(visible, self.wishes.not_understood))

    def to_plain(self) -> dict[str, Any]:
        """Return the understanding as plain data: prompt, wishes, notes and not_understood."""
        return {
            "prompt": visible(self.prompt),
            "wishes": [{"said": said, "wish": wish} for said, wish in self.rows],
            "notes": list(self.notes),
            "not_understood": list(self.not_understood),
        }


def understood(
    prompt: str, wishes: Wishes, given: Mapping[str, Any], themes: Themes | None = None
) -> Understanding:
    """Join the wishes of a prompt with options.

    Args:
        prompt: The prompt.
        wishes: Wishes that were read from it.
        given: Options that the user gave, by name; they win.
        themes: Themes that the checkpoint knows; None while it is not loaded.
    """
    options = _options(wishes)
    notes: list[str] = []
    for name, value in given.items():
        for other in (name, _EXCLUDED.get(name, "")):
            if other in options and (other != name or options[other] != value):
                dropped = options.pop(other)
                notes.append(
                    f"--{name.replace('_', '-')} {value} wins over the prompt's "
                    f"{spoken(other)} {dropped}"
                )
    if themes is not None:
        _yield_to(options, given, themes, notes)
        _settle_theme(options, wishes, given, themes, notes)
        _settle_domain(options, wishes, given, themes, notes)
    return Understanding(prompt=prompt, wishes=wishes, options=options, notes=tuple(notes))


def _options(wishes: Wishes) -> dict[str, Any]:
    found = {**msgspec.structs.asdict(wishes), "min_passage": wishes.min_passage_m}
    options = {name: found[name] for name in _OPTIONS if found[name] is not None}
    # As texts, because these options are texts on the command line.
    if wishes.outline_m is not None:
        options["outline"] = ",".join(f"{side:g}" for side in wishes.outline_m)
    if "areas" in options:
        options["areas"] = str(options["areas"])
    return options


def _yield_to(
    options: dict[str, Any], given: Mapping[str, Any], themes: Themes, notes: list[str]
) -> None:
    """Drop the prompt's theme or domain if the user gave the other one and the two do not match."""
    for name, other in (("domain", "theme"), ("theme", "domain")):
        if name not in given or other not in options:
            continue
        # Unknown themes are not dropped here: `_settle_theme` finds the nearest for them.
        pair = {name: given[name], other: options[other]}
        known = {theme for group in themes.values() for theme in group}
        if pair["theme"] in known and pair["theme"] not in themes.get(pair["domain"], ()):
            notes.append(f"--{name} {given[name]} wins over the prompt's {other} {options[other]}")
            del options[other]


def _settle_theme(
    options: dict[str, Any],
    wishes: Wishes,
    given: Mapping[str, Any],
    themes: Themes,
    notes: list[str],
) -> None:
    """Replace a theme that the checkpoint does not know, or add one that fits the things."""
    known = {theme for group in themes.values() for theme in group}
    asked = options.get("theme")
    if asked is not None and asked not in known:
        nearest = next((each for each in _nearest(asked) if each in known), None)
        del options["theme"]
        if nearest is None:
            notes.append(f"the checkpoint knows no theme like {asked}; the theme is drawn")
        else:
            options["theme"] = nearest
            notes.append(f"the checkpoint knows no theme {asked}; {nearest} is the nearest")
    elif asked is None and not {"theme", "complete", "redo"} & given.keys():
        usual = _usual(wishes, known & _of_domain(themes, options, given))
        if usual is not None:
            theme, thing = usual
            options["theme"] = theme
            notes.append(f"theme {theme}, because {named(thing)} is usual there")


def _settle_domain(
    options: dict[str, Any],
    wishes: Wishes,
    given: Mapping[str, Any],
    themes: Themes,
    notes: list[str],
) -> None:
    """Choose a domain in which everything that is asked for can stand."""
    if "domain" in options or {"domain", "complete", "redo"} & given.keys():
        return
    needed = [(each.thing, domains_of(each.thing)) for each in wishes.demands if each.least]
    # Only things that stand in a single domain decide, such as a sofa.
    only = {next(iter(places_)): name for name, places_ in needed if len(places_) == 1}
    if not only:
        return
    domain = next(iter(only)) if len(only) == 1 else "mixed"
    theme = options.get("theme", given.get("theme"))
    if theme is not None:
        # A theme restricts the choice: an outdoor one gets rooms only if it exists as mixed.
        has_theme = [each for each, group in themes.items() if theme in group]
        if "indoor" not in only or "indoor" in has_theme or "mixed" not in has_theme:
            return
        domain = "mixed"
    elif domain not in themes:
        return
    options["domain"] = domain
    names = " and ".join(f"{named(name)} stands {where}s" for where, name in only.items())
    notes.append(f"domain {domain}, because {names}")


def _nearest(theme: str) -> list[str]:
    """Return themes like one, the most similar first, and behind them those like these."""
    found = list(places()[theme].nearest) if theme in places() else []
    for each in tuple(found):
        found += [other for other in places()[each].nearest if other not in found]
    return found


def _of_domain(themes: Themes, options: Mapping[str, Any], given: Mapping[str, Any]) -> set[str]:
    domain = given.get("domain", options.get("domain"))
    return {theme for each, group in themes.items() if domain in {None, each} for theme in group}


def _usual(wishes: Wishes, themes: Collection[str]) -> tuple[str, str] | None:
    """Return a theme in which one of the things is usual, and that thing; None if there is none."""
    for each in wishes.demands:
        for theme in things()[each.thing].themes if each.least else ():
            if theme in themes:
                return theme, each.thing
    return None
