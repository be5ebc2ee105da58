"""Lower bounds of the sizes of networks that a configuration describes, without PyTorch.

A file of a few kilobytes may describe a network of 100 GB. It is refused before any memory is
taken. The bounds leave out small parts beside the layers, so a real network is larger by about a
fifth, and by the table of its kinds.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from aeroscene.learning.training.checkpoint_facts import CheckpointError, Part, read_shapes
from aeroscene.learning.training.config import TrainingError

MOST_NUMBERS = 1_000_000_000
"""Largest network that is trained. Ours has 6 million numbers, and Adam keeps four of each."""
_SECTIONS: Mapping[Part, str] = {
    "denoiser": "model",
    "writer": "writer",
    "contents": "contents",
    "prior": "prior",
}


def least_numbers(part: Part, cfg: Any) -> int:
    """Return the least number of weights of the network of a part, by its section."""
    square = cfg.width**2
    if part == "writer":
        # Attention has four square matrices, the FFN two of `ffn_ratio` squares.
        return cfg.layers * (4 + 2 * cfg.ffn_ratio) * square
    if part == "contents":
        # A GRU has three gates with two square matrices each.
        return 6 * cfg.layers * square
    if part == "prior":
        return square + 7 * cfg.n_parts * cfg.width
    if cfg.denoiser == "tokens":
        return cfg.blocks * (14 + 6 * cfg.ffn_ratio) * square
    # The 3D convolutions have two kernels of 27 squares.
    levels = 10 * sum(width**2 for width in cfg.unet_widths)
    return 4 * cfg.blocks * square + levels + 54 * cfg.grid_channels**2


def require_trainable(sections: Mapping[str, Any]) -> None:
    """Refuse sections whose networks are beyond what a machine trains.

    Raises:
        TrainingError: If a network has more than `MOST_NUMBERS` weights.
    """
    for part, name in _SECTIONS.items():
        if name in sections and (count := least_numbers(part, sections[name])) > MOST_NUMBERS:
            raise TrainingError(
                f"[{name}] describes a network of {count:,} numbers or more; valid: at most "
                f"{MOST_NUMBERS:,}; take less width, or fewer layers"
            )


def require_filled(path: Path, sections: Mapping[str, Any]) -> None:
    """Refuse a checkpoint whose weights are too few for the networks that it describes.

    Raises:
        CheckpointError: If one of its parts has too few.
    """
    shapes = read_shapes(path)
    for part, name in _SECTIONS.items():
        found = sum(math.prod(s) for key, s in shapes.items() if key.startswith(f"{part}."))
        if found and name in sections and least_numbers(part, sections[name]) > found:
            raise CheckpointError(
                f"checkpoint {str(path)!r} has {found:,} numbers of the {part}; valid: "
                f"{least_numbers(part, sections[name]):,} or more for the network that it "
                "describes; copy it again"
            )
