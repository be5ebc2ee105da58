"""A language model reads a prompt: one request to an endpoint that the user names.

Any server that speaks `chat/completions` as OpenAI's does will do. Its answer is data from a
stranger: bounded in size and time, decoded in one typed pass into `Wishes`, its names checked.
"""

from __future__ import annotations

import difflib
import ipaddress
from collections.abc import Mapping
from http import HTTPStatus
from typing import Annotated
from urllib.parse import SplitResult, urlsplit

import msgspec

from scenarios.generation.prompts.instructions import instructions, schema
from scenarios.generation.prompts.parsing.reading import plain
from scenarios.generation.prompts.posting import MOST_BYTES, Answer, posted
from scenarios.generation.prompts.vocabulary import places, things, unmeasurable
from scenarios.generation.prompts.wishes import Count, PromptError, Relation, Wishes, checked

KEY = "OPENAI_API_KEY"
"""Environment variable of the key that the endpoint may want."""
MOST_SECONDS = 120.0
"""Time for the whole answer."""
_TO = "/chat/completions"


class _Message(msgspec.Struct):
    content: Annotated[str, msgspec.Meta(max_length=MOST_BYTES)]


class _Choice(msgspec.Struct):
    message: _Message


class _Completion(msgspec.Struct):
    choices: Annotated[list[_Choice], msgspec.Meta(min_length=1, max_length=16)]


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
        environment: Where the key is looked for. It is sent over https and to this machine only.
        own_themes: Themes of a checkpoint beside those of the vocabulary.
        most_seconds: Time for the whole answer.

    Raises:
        PromptError: If the endpoint cannot be reached, or its answer cannot be used.
    """
    text = plain(prompt)
    address = asked_address(endpoint)
    body = msgspec.json.encode(
        {
            "model": model,
            "temperature": 0,
            "messages": [
                {"role": "system", "content": instructions(own_themes)},
                {"role": "user", "content": text},
            ],
            "response_format": {
                "type": "json_schema",
                "json_schema": {"name": "wishes", "schema": schema()},
            },
        }
    )
    headers = {"Content-Type": "application/json", "Accept": "application/json"}
    if (key := environment.get(KEY, "").strip()) and _is_private(address):
        headers["Authorization"] = f"Bearer {_sendable(key)}"
    found = posted(address, _path(address), body, headers, most_seconds)
    return _known(_decoded(_body(found, endpoint, most_seconds), endpoint), own_themes)


def asked_address(endpoint: str) -> SplitResult:
    """The parts of an endpoint's address.

    Raises:
        PromptError: If it is none.
    """
    parts = urlsplit("")
    try:
        parts = urlsplit(endpoint)
        is_valid = parts.scheme in {"http", "https"} and bool(parts.hostname)
        # The port is parsed when it is asked for.
        is_valid = is_valid and parts.port != 0 and not (parts.username or parts.query)
        is_valid = (
            is_valid and endpoint.isascii() and endpoint.isprintable() and " " not in endpoint
        )
    except ValueError:
        is_valid = False
    if not is_valid:
        raise PromptError(
            f"prompt-endpoint is {endpoint!r}; valid: an address such as http://127.0.0.1:8080/v1"
        )
    return parts


def _path(address: SplitResult) -> str:
    path = address.path.rstrip("/")
    return path if path.endswith(_TO) else f"{path}{_TO}"


def _body(found: Answer | Exception | None, endpoint: str, most_seconds: float) -> bytes:
    """The body of an answer that is one."""
    valid = "an endpoint that answers chat/completions"
    if found is None or isinstance(found, TimeoutError):
        raise PromptError(
            f"prompt-endpoint {endpoint!r} did not answer within {most_seconds:g} s; "
            "valid: a faster model, or no --prompt-endpoint"
        )
    if isinstance(found, Exception):
        reason = " ".join(f"{type(found).__name__}: {found}".split())[:200]
        raise PromptError(f"prompt-endpoint {endpoint!r} cannot be used ({reason}); valid: {valid}")
    if found.status != HTTPStatus.OK:
        said = " ".join(found.body[:200].decode("utf-8", "replace").split())
        raise PromptError(
            f"prompt-endpoint {endpoint!r} answered with status {found.status} ({said}); "
            f"valid: {valid}"
        )
    if len(found.body) > MOST_BYTES:
        raise PromptError(
            f"prompt-endpoint {endpoint!r} answered with more than {MOST_BYTES} bytes; "
            "valid: an answer by the schema that it was sent"
        )
    return found.body


def _decoded(data: bytes, endpoint: str) -> Wishes:
    try:
        answer = msgspec.json.decode(data, type=_Completion)
        content = answer.choices[0].message.content.strip()
        content = content.removeprefix("```json").removeprefix("```").removesuffix("```")
        return msgspec.json.decode(content.encode(), type=Wishes)
    except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
        reason = " ".join(str(error).split())[:200]
        raise PromptError(
            f"prompt-endpoint {endpoint!r} gave no wishes ({reason}); "
            "valid: a model that answers by a JSON schema, or no --prompt-endpoint"
        ) from None


def _known(wishes: Wishes, own_themes: frozenset[str]) -> Wishes:
    """The wishes whose names are in the vocabulary; the others count as not understood."""
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


def _is_private(address: SplitResult) -> bool:
    """Whether nobody on the way can read what is sent."""
    if address.scheme == "https" or address.hostname == "localhost":
        return True
    try:
        return ipaddress.ip_address(address.hostname or "").is_loopback
    except ValueError:
        return False


def _sendable(key: str) -> str:
    """A key that a header can hold; the message does not show it."""
    if not (key.isascii() and key.isprintable()):
        raise PromptError(f"{KEY} holds characters that no header may have; valid: the key alone")
    return key
