"""One request to a server that speaks `chat/completions` as OpenAI's does.

Many servers speak this API, hosted ones and local ones such as llama.cpp, so one small client does
for all, and no library of a vendor is needed. An answer is data from a stranger. It is bounded in
size and time, and decoded in one typed pass.
"""

from __future__ import annotations

import ipaddress
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from http import HTTPStatus
from typing import Annotated, Any
from urllib.parse import SplitResult, urlsplit

import msgspec

from scenarios.chat.http_request import MOST_BYTES, Answer, posted

KEY = "OPENAI_API_KEY"
"""Environment variable with the key that an endpoint may require."""
MOST_SECONDS = 120.0
"""Default time limit for the whole answer."""
_TO = "/chat/completions"


class ChatError(ValueError):
    """An endpoint cannot be used; the message names the option and the address in one line."""


class _Message(msgspec.Struct):
    content: Annotated[str, msgspec.Meta(max_length=MOST_BYTES)]


class _Choice(msgspec.Struct):
    message: _Message


class _Completion(msgspec.Struct):
    choices: Annotated[list[_Choice], msgspec.Meta(min_length=1, max_length=16)]


@dataclass(frozen=True, kw_only=True, slots=True)
class ChatModel:
    """A language model at an address, with the words for messages about it."""

    endpoint: str
    """Base address such as `http://127.0.0.1:8080/v1`."""
    model: str = "default"
    """Name of the model there."""
    option: str = "endpoint"
    """Name of the option that gave the address, for messages."""
    instead: str = ""
    """Alternative to a model that does not answer, for messages."""
    most_seconds: float = MOST_SECONDS
    """Time limit for the whole answer."""

    @property
    def address(self) -> SplitResult:
        """Parts of the address.

        Raises:
            ChatError: If the endpoint is no address of a server.
        """
        return address_of(self.endpoint, self.option)


def ask_model(
    chat: ChatModel,
    messages: Sequence[Mapping[str, Any]],
    environment: Mapping[str, str],
    *,
    schema: tuple[str, Mapping[str, Any]] | None = None,
) -> str:
    """Send messages to a model, and return its answer.

    Args:
        chat: Model to ask.
        messages: Messages of the API: `role`, and `content` as a text or as parts.
        environment: Variables among which the key is looked for. The key is sent over https, and
            without it to this machine only.
        schema: Name of a JSON schema that the answer should follow, and the schema.

    Returns:
        The content of its message, at most 256 KiB. It need not follow the schema.

    Raises:
        ChatError: If the endpoint cannot be reached, or does not answer as the API says.
    """
    address = chat.address
    # Temperature 0, so that the same question gets the same answer as far as the server allows.
    plain: dict[str, Any] = {"model": chat.model, "temperature": 0, "messages": messages}
    if schema is not None:
        name, shape = schema
        wanted = {"type": "json_schema", "json_schema": {"name": name, "schema": shape}}
        plain["response_format"] = wanted
    headers = {"Content-Type": "application/json", "Accept": "application/json"}
    if (key := environment.get(KEY, "").strip()) and is_private(address):
        headers["Authorization"] = f"Bearer {_sendable(key)}"
    body = msgspec.json.encode(plain)
    found = posted(address, _path(address), body, headers, chat.most_seconds)
    try:
        answer = msgspec.json.decode(_body(found, chat), type=_Completion)
    except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
        reason = " ".join(str(error).split())[:200]
        raise ChatError(
            f"{chat.option} {chat.endpoint!r} gave no message ({reason}); "
            "valid: an endpoint that answers chat/completions"
        ) from None
    return answer.choices[0].message.content


def without_fence(content: str) -> str:
    """Return JSON without the block of code that many models wrap around it.

    Args:
        content: Content of an answer.
    """
    inner = content.strip().removeprefix("```json").removeprefix("```")
    return inner.removesuffix("```").strip()


def address_of(endpoint: str, option: str) -> SplitResult:
    """Parse an endpoint's address.

    Args:
        endpoint: Address with http or https, without user name and query.
        option: Name of the option that gave it, for the message.

    Raises:
        ChatError: If it is no such address.
    """
    parts = urlsplit("")
    try:
        parts = urlsplit(endpoint)
        is_valid = parts.scheme in {"http", "https"} and bool(parts.hostname)
        # `urlsplit` parses the port only when it is read, and raises ValueError then.
        is_valid = is_valid and parts.port != 0 and not (parts.username or parts.query)
        is_valid = (
            is_valid and endpoint.isascii() and endpoint.isprintable() and " " not in endpoint
        )
    except ValueError:
        is_valid = False
    if not is_valid:
        raise ChatError(
            f"{option} is {endpoint!r}; valid: an address such as http://127.0.0.1:8080/v1"
        )
    return parts


def is_private(address: SplitResult) -> bool:
    """Return true if nobody on the network can read the request: https, or this machine.

    Args:
        address: Parts of the endpoint's address.
    """
    if address.scheme == "https" or address.hostname == "localhost":
        return True
    try:
        return ipaddress.ip_address(address.hostname or "").is_loopback
    except ValueError:
        return False


def _path(address: SplitResult) -> str:
    # Users paste either the base address or the full one.
    path = address.path.rstrip("/")
    return path if path.endswith(_TO) else f"{path}{_TO}"


def _body(found: Answer | Exception | None, chat: ChatModel) -> bytes:
    """Return the body of a successful answer, and refuse everything else in one line."""
    valid = "an endpoint that answers chat/completions"
    who = f"{chat.option} {chat.endpoint!r}"
    # None is the limit for the whole answer, TimeoutError the socket's own for a single step.
    if found is None or isinstance(found, TimeoutError):
        instead = chat.instead and f", or {chat.instead}"
        raise ChatError(
            f"{who} did not answer within {chat.most_seconds:g} s; valid: a faster model{instead}"
        )
    if isinstance(found, Exception):
        reason = " ".join(f"{type(found).__name__}: {found}".split())[:200]
        raise ChatError(f"{who} cannot be used ({reason}); valid: {valid}")
    if found.status != HTTPStatus.OK:
        said = " ".join(found.body[:200].decode("utf-8", "replace").split())
        raise ChatError(f"{who} answered with status {found.status} ({said}); valid: {valid}")
    if len(found.body) > MOST_BYTES:
        raise ChatError(
            f"{who} answered with more than {MOST_BYTES} bytes; "
            "valid: an answer by the schema that it was sent"
        )
    return found.body


def _sendable(key: str) -> str:
    """Return a key that a header can hold; the error's message does not show the key."""
    if not (key.isascii() and key.isprintable()):
        raise ChatError(f"{KEY} holds characters that no header may have; valid: the key alone")
    return key
