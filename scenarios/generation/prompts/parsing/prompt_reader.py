"""From a prompt to wishes: sizes, then lexemes, then clauses, then checks."""

from __future__ import annotations

import msgspec

from aeroscene.files.visible import is_visible
from scenarios.generation.prompts.parsing.clauses import Clauses
from scenarios.generation.prompts.parsing.lexemes import lexemes
from scenarios.generation.prompts.parsing.mentions import Tie, counts_of, relation_of
from scenarios.generation.prompts.parsing.sizes import Sizes, without_sizes
from scenarios.generation.prompts.vocabulary import places
from scenarios.generation.prompts.wishes import PromptError, Reading, Relation, Wishes, checked

MOST_CHARACTERS = 1000
"""Greatest length of a prompt."""
_SIDES_M = {
    False: {"tiny": (50.0, 50.0), "small": (60.0, 60.0), "large": (95.0, 90.0)},
    True: {"tiny": (20.0, 18.0), "small": (24.0, 22.0), "large": (30.0, 28.0)},
}
"""Sides of sites, outdoors and indoors (True); sites of shipped scenes lie from small to large."""
_HUGE_M = {False: (110.0, 110.0), True: (36.0, 30.0)}


def read_prompt(text: str, own_themes: frozenset[str] = frozenset()) -> Wishes:
    """Read the wishes of a prompt with our own parser.

    Args:
        text: English, up to `MOST_CHARACTERS`.
        own_themes: Themes of a checkpoint beside those of the vocabulary, known by their names.

    Returns:
        The wishes, and under `not_understood` the words that became none.

    Raises:
        PromptError: If it is empty, too long, or contradicts itself.
    """
    # Sizes come out first: in "80 by 60 m" the parser would take "by" for a relation.
    sizes = without_sizes(plain(text).lower())
    clauses = Clauses()
    clauses.read(lexemes(sizes.text, own_themes))
    outline_m, readings = _outline(clauses, sizes)
    # Relations come before counts, because they mark the things that they count themselves.
    relations, unknown = _relations(clauses.ties)
    site = clauses.site
    if site.theme:
        readings.insert(0, Reading("theme", site.said))
    for option, (_, said) in clauses.settings.options.items():
        readings.append(Reading(option, said))
    options = {option: value for option, (value, _) in clauses.settings.options.items()}
    found = {
        "theme": site.theme or None,
        "outline_m": outline_m,
        "min_passage_m": sizes.min_passage_m,
        "counts": counts_of(clauses.mentions),
        "relations": relations,
        "readings": readings,
        "not_understood": [*clauses.unknown, *unknown],
        **options,
    }
    try:
        # Converted rather than constructed, because msgspec checks limits only on conversion.
        return checked(msgspec.convert(msgspec.to_builtins(found), Wishes))
    except msgspec.ValidationError as error:
        raise PromptError(f"prompt asks for too much ({error}); valid: up to 24 wishes") from None


def plain(text: str) -> str:
    """Return a prompt on one line, with plain quotes and without control characters.

    Args:
        text: Prompt as the user wrote it.

    Raises:
        PromptError: If it is empty or too long.
    """
    shown = "".join(each if is_visible(each) else " " for each in text.replace("\u2019", "'"))
    line = " ".join(shown.split())
    if not line:
        raise PromptError("prompt is empty; valid: words such as 'a park with two benches'")
    if len(line) > MOST_CHARACTERS:
        raise PromptError(f"prompt has {len(line)} characters; valid: at most {MOST_CHARACTERS}")
    return line


def _relations(ties: list[Tie]) -> tuple[list[Relation], list[str]]:
    """Return the relations that can be measured, and the words of those that cannot."""
    found: list[Relation] = []
    unknown: list[str] = []
    for tie in ties:
        wish = relation_of(tie)
        if isinstance(wish, str):
            unknown.append(wish)
        else:
            found.append(wish)
    return found, unknown


def _outline(clauses: Clauses, sizes: Sizes) -> tuple[tuple[float, float] | None, list[Reading]]:
    readings = list(sizes.readings)
    if clauses.settings.size is None:
        return sizes.outline_m, readings
    size, said = clauses.settings.size
    if sizes.outline_m is not None:
        raise PromptError(
            f"prompt asks for a {said} site and for one of {readings[-1].said!r}; "
            "valid: one of the two"
        )
    readings.append(Reading("outline", said))
    theme = clauses.site.theme
    is_indoor = clauses.settings.options.get("domain", ("", ""))[0] == "indoor"
    is_indoor |= theme in places() and places()[theme].is_indoor
    return (_SIDES_M[is_indoor] | {"huge": _HUGE_M[is_indoor]})[size], readings
