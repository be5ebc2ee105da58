"""A policy from a file: what it wants to see, and the action that it takes."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from aeroscene.files import open_regular
from scenarios.environments.interface.actions import N_ACTIONS, checked_actions
from scenarios.policies.description import (
    Description,
    PolicyError,
    Scaling,
    description_path,
    read_description,
)
from scenarios.policies.graphs import NUMBERS, read_graph
from scenarios.policies.layers import MOST_BYTES, read_layers

_SUFFIXES = (".zip", ".onnx")


class Policy:
    """A policy that was learnt, without exploration: the same observation gives the same action.

    Attributes:
        description: What it was trained for.
    """

    def __init__(
        self, description: Description, act: Callable[[dict[str, np.ndarray]], np.ndarray]
    ) -> None:
        self.description = description
        self._act = act

    def action(self, observation: Any) -> Float[np.ndarray, " a"]:
        """Return the action in a situation, four numbers of -1 to 1.

        Args:
            observation: Observation as the environment of the description gives it.

        Raises:
            EnvironmentInputError: If the policy's answer has another shape or is not finite.
        """
        parts = dict(observation) if isinstance(observation, dict) else {NUMBERS: observation}
        scaling = self.description.scaling
        if scaling is not None and NUMBERS in parts:
            parts[NUMBERS] = _scaled(parts[NUMBERS], scaling)
        return checked_actions(self._act(parts), (N_ACTIONS,))


def read_policy(path: Path) -> Policy:
    """Read a policy and its description; nothing in either is executed.

    Args:
        path: A Stable-Baselines3 file (.zip) or an ONNX file, with a description beside it.

    Raises:
        PolicyError: If it cannot be used; one line says why.
    """
    if path.suffix not in _SUFFIXES:
        raise PolicyError(f"policy {str(path)!r}: valid: FILE.zip of Stable-Baselines3, FILE.onnx")
    data = _content(path)
    description = read_description(path)
    shapes = _shapes(description)
    if path.suffix == ".onnx":
        return Policy(description, read_graph(path, data, shapes, N_ACTIONS))
    if tuple(shapes) != (NUMBERS,) or description.network is None:
        raise PolicyError(
            f"description {str(description_path(path))!r} has no network of numbers alone; valid: "
            "one that aeroscene.save_policy wrote, or an ONNX file for images and other networks"
        )
    n_inputs = shapes[NUMBERS][0]
    act = read_layers(path, data, description.network, n_inputs, N_ACTIONS)
    return Policy(description, lambda parts: act(parts[NUMBERS]))


def digest(path: Path) -> str:
    """Return the SHA-256 of a policy and its description, which together decide its flights.

    Raises:
        PolicyError: If either cannot be read.
    """
    both = hashlib.sha256(_content(path))
    both.update(_content(description_path(path)))
    return both.hexdigest()


def _content(path: Path) -> bytes:
    try:
        with open_regular(path) as file:
            data = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise PolicyError(
            f"policy {str(path)!r} cannot be read: {error.strerror}; valid: FILE.zip of "
            "Stable-Baselines3 or FILE.onnx, with FILE.json beside it"
        ) from None
    if len(data) > MOST_BYTES:
        raise PolicyError(
            f"policy {str(path)!r} holds more than {MOST_BYTES >> 20} MiB; valid: at most that"
        )
    return data


def _shapes(description: Description) -> dict[str, tuple[int, ...]]:
    """Return the shape of each part of an observation by its name."""
    from scenarios.environments.interface.observations import layout

    cfg = description.cfg.observation
    shapes: dict[str, tuple[int, ...]] = {}
    if cfg.has_numbers:
        shapes[NUMBERS] = (sum(size for _, size in layout(cfg)),)
    if cfg.depth is not None:
        width, height = cfg.depth
        shapes |= dict.fromkeys(("depth", *cfg.segments), (height, width))
    return shapes


def _scaled(numbers: np.ndarray, scaling: Scaling) -> np.ndarray:
    mean, std = (np.asarray(each, np.float32) for each in (scaling.mean, scaling.std))
    return np.clip((numbers - mean) / std, -scaling.clip, scaling.clip)
