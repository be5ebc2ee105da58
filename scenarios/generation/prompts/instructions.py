"""Instructions for a language model: the task, the vocabulary and the schema of its answer.

The vocabulary is in the instructions, so that a model of any size maps words to names that scenes
know. The rules repeat how our parser reads numbers, so that both readings of a prompt agree.
"""

from __future__ import annotations

from functools import cache
from typing import Any, get_args

import msgspec

from scenarios.generation.prompts.vocabulary import places, things
from scenarios.generation.prompts.wishes import RelationName, Wishes

_TASK = """\
You turn a wish for a scene in which a drone flies into JSON by the schema that you are given.
Answer with one JSON object and nothing else. Use only these names:
themes: {themes}
things: {things}
relations: {relations}
Rules:
- theme is what the whole place is; null if the wish does not say.
- counts: one entry for each thing that is asked for. least and most are the numbers: "two" is 2 and
  2, "at least three" is 3 and null, "no" is 0 and 0, "a" is 1 and null, a plural is 2 and null,
  "many" is 10 and null (5 and null for buildings).
- relations: one entry for each thing that stands somewhere; thing is counted, host is what it
  stands to. Do not repeat it under counts. between has a second host in other.
- density: 1.5 for crowded, 0.6 for sparse; clutter: 3 for cluttered; outline_m: sides in metres, 15
  to 150, only if the wish has a size; objects, areas, min_passage_m, difficulty: only if named.
- said: the words of the wish that an entry comes from. readings: the same for theme, density,
  clutter, outline, domain and the other options.
- not_understood: every word for which there is no name above. Never leave one out."""


@cache
def instructions(own_themes: frozenset[str] = frozenset()) -> str:
    """Return the task for a language model.

    Args:
        own_themes: Themes of a checkpoint beside those of the vocabulary.
    """
    return _TASK.format(
        themes=", ".join([*places(), *sorted(own_themes - places().keys())]),
        things=", ".join(things()),
        relations=", ".join(get_args(RelationName)),
    )


@cache
def schema() -> dict[str, Any]:
    """Return the JSON schema of the answer, which is that of `Wishes`."""
    return msgspec.json.schema(Wishes)
