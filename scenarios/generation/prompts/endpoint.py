"""Reading of a prompt by a language model, with one request to an endpoint that the user names.

A language model understands more phrases than our parser. Any server that speaks `chat/completions`
as OpenAI's does will do. Its answer is data from a stranger. It is therefore decoded in one typed
pass into `Wishes`, as our parser gives them, and every name is checked against the vocabulary.
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping

import msgspec

from scenarios.chat.completions import (
    MOST_SECONDS,
    ChatError,
    ChatModel,
    ask_model,
    without_fence,
)
from scenarios.generation.prompts.instructions import instructions, schema
from scenarios.generation.prompts.parsing.prompt_reader import plain
from scenarios.generation.prompts.vocabulary import places, things, unmeasurable
from scenarios.generation.prompts.wishes import Count, PromptError, Relation, Wishes, checked


def ask_endpoint(
    prompt: str,
    endpoint: str,
    model: str,
    environment: Mapping[str, str],
    *,
    own_themes: frozenset[str] = frozenset(),
    most_seconds: float = MOST_SECONDS,
) -> Wishes:
    """Let a language model read the wishes of a prompt.

    Args:
        prompt: The prompt.
        endpoint: Base address such as `http://127.0.0.1:8080/v1`.
        model: Name of the model there.
        environment: Variables among which the key is looked for. The key is sent over https, and
            without it to this machine only.
        own_themes: Themes of a checkpoint beside those of the vocabulary.
        most_seconds: Time limit for the whole answer.

    Returns:
        The wishes. Names that are not in the vocabulary count as not understood.

    Raises:
        PromptError: If the endpoint cannot be reached, or its answer cannot be used.
    """
    chat = ChatModel(
        endpoint=endpoint,
        model=model,
        option="prompt-endpoint",
        instead="no --prompt-endpoint",
        most_seconds=most_seconds,
    )
    # `plain` removes control characters and bounds the length of what is sent.
    messages = [
        {"role": "system", "content": instructions(own_themes)},
        {"role": "user", "content": plain(prompt)},
    ]
    try:
        content = ask_model(chat, messages, environment, schema=("wishes", schema()))
    except ChatError as error:
        raise PromptError(str(error)) from None
    return _known(_decoded(content, endpoint), own_themes)


def _decoded(content: str, endpoint: str) -> Wishes:
    try:
        return msgspec.json.decode(without_fence(content).encode(), type=Wishes)
    except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
        reason = " ".join(str(error).split())[:200]
        raise PromptError(
            f"prompt-endpoint {endpoint!r} gave no wishes ({reason}); "
            "valid: a model that answers by a JSON schema, or no --prompt-endpoint"
        ) from None


def _known(wishes: Wishes, own_themes: frozenset[str]) -> Wishes:
    """Return the wishes whose names are in the vocabulary; others become "not understood"."""
    unknown: list[str] = []

    def is_known(wish: Count) -> bool:
        names = [wish.thing]
        if isinstance(wish, Relation):
            names += [wish.host, *filter(None, [wish.other])]
        for name in names:
            if name not in things():
                unknown.append(f"{wish.said or name} ({_unknown(name)})"[:200])
                return False
        reason = unmeasurable(wish) if isinstance(wish, Relation) else None
        if reason is not None:
            # 200 characters are the limit of a text in `Wishes`.
            unknown.append(f"{wish.said or wish.title} ({reason})"[:200])
        return reason is None

    theme = wishes.theme
    if theme is not None and theme not in {*places(), *own_themes}:
        unknown.append(f"theme {theme} (none of {', '.join(places())})"[:200])
        theme = None
    found = msgspec.structs.replace(
        wishes,
        theme=theme,
        counts=tuple(filter(is_known, wishes.counts)),
        relations=tuple(filter(is_known, wishes.relations)),
    )
    words = (*found.not_understood, *unknown)
    return checked(msgspec.structs.replace(found, not_understood=words))


def _unknown(name: str) -> str:
    near = difflib.get_close_matches(name, things(), n=2)
    return f"no thing {name!r}" + (f", near: {', '.join(near)}" if near else "")
