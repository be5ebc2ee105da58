"""Questions to a vision-language model at each look around, and the parser of its answers.

A model points at a pixel, and the depth image turns the pixel into a place, so the model need not
estimate distances. The answer is one JSON object, whose type checks every range.
"""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import msgspec
import numpy as np

from aeroscene.files.visible import shown
from scenarios.chat.completions import without_fence

INSTRUCTIONS = """You steer a drone that must land where a text says. You get camera images that \
were taken from one point: first the views ahead, clockwise by compass from north, then the view \
straight down, whose top is north. Answer with one JSON object and nothing else:
{"action": "land", "image": 2, "x": 0.4, "y": 0.7} to land on the surface at that point of image 2;
{"action": "go", "image": 2, "x": 0.4, "y": 0.5} to fly some metres that way and look again;
{"action": "climb"} to rise by 3 m and look again;
{"action": "give_up"} if the place cannot be found.
Images are counted from 0. x runs from 0 at the left to 1 at the right, y from 0 at the top to 1."""
AGAIN = "That was not understood: {}. Answer with one JSON object as described, and nothing else."

_Share = Annotated[float, msgspec.Meta(ge=0.0, le=1.0)]
_MOST_SHOWN = 120


class AnswerError(ValueError):
    """An answer of a model is not understood; the message says why, and shows its beginning."""


class Choice(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Next step of the drone."""

    action: Literal["land", "go", "climb", "give_up"]
    image: Annotated[int, msgspec.Meta(ge=0, le=63)] = 0
    """Number of the image that has the point, from 0."""
    x: _Share = 0.5
    """Distance of the point from the left, as a share of the width."""
    y: _Share = 0.5
    """Distance of the point from the top, as a share of the height."""


@dataclass(frozen=True, slots=True)
class Question:
    """Question after one look around.

    Attributes:
        text: Goal, and a note about the last step.
        images: Colours of each image, uint8 (height, width, 3).
    """

    text: str
    images: Sequence[np.ndarray]

    def messages(self) -> list[dict[str, Any]]:
        """Return the question as messages of the API, with the images as JPEG."""
        parts: list[dict[str, Any]] = [{"type": "text", "text": self.text}]
        for image in self.images:
            url = f"data:image/jpeg;base64,{base64.b64encode(_jpeg(image)).decode()}"
            parts.append({"type": "image_url", "image_url": {"url": url}})
        return [
            {"role": "system", "content": INSTRUCTIONS},
            {"role": "user", "content": parts},
        ]


def schema() -> dict[str, Any]:
    """Return the JSON schema of an answer."""
    # Without the reference that msgspec puts around a named type.
    (found,), components = msgspec.json.schema_components([Choice])
    return components[found["$ref"].rsplit("/", 1)[-1]] if "$ref" in found else found


def read_choice(content: str, n_images: int) -> Choice:
    """Read an answer.

    Args:
        content: Content of the model's message; words around the JSON object are ignored.
        n_images: Number of images that it was sent.

    Raises:
        AnswerError: If it holds no choice, or one of an image that is not there.
    """
    inner = without_fence(content)
    # Models like to explain themselves before and after the object.
    first, last = inner.find("{"), inner.rfind("}")
    beginning = shown(inner[:_MOST_SHOWN])
    if first < 0 or last < first:
        raise AnswerError(f"{beginning} holds no JSON object")
    try:
        choice = msgspec.json.decode(inner[first : last + 1].encode(), type=Choice)
    except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
        reason = " ".join(str(error).split())[:_MOST_SHOWN]
        raise AnswerError(f"{beginning} is no choice ({reason})") from None
    if choice.image >= n_images:
        raise AnswerError(f"image {choice.image} is not there; valid: 0 to {n_images - 1}")
    return choice


def _jpeg(image: np.ndarray) -> bytes:
    import cv2

    # OpenCV's colours are blue, green, red.
    return cv2.imencode(".jpg", np.ascontiguousarray(image[..., ::-1]))[1].tobytes()
