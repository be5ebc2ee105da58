"""Configuration of the writer's network."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from aeroscene.ranges import Range, require_ranges
from aeroscene.scene import SceneError


class WriterError(SceneError):
    """A writer cannot be used; one line has the fault and valid values."""


@dataclass(frozen=True, kw_only=True)
class WriterCfg:
    """Shape of the writer's network, and the threshold of its draws."""

    width: Annotated[int, Range(8, 1024)] = 160
    """Width of an element."""
    layers: Annotated[int, Range(1, 16)] = 4
    """Blocks of attention and FFN."""
    heads: Annotated[int, Range(2, 16)] = 4
    """Attention heads, even: half of them see kin alone."""
    ffn_ratio: Annotated[int, Range(1, 8)] = 3
    """Hidden width of the FFN by `width`."""
    kind_width: Annotated[int, Range(4, 512)] = 96
    """Width of a kind's embedding."""
    dropout: Annotated[float, Range(0.0, 0.9)] = 0.1
    """Share of activations that training switches off."""
    least_share: Annotated[float, Range(0.0, 1.0)] = 0.05
    """Kinds below this share of the likeliest one's probability are never drawn (min-p, Nguyen et
    al. 2024); all others are drawn as often as the network says. With a greater share, scenes would
    be nearer to the training scenes than other scenes of the grammar are. Training lowers it if it
    would exclude too many kinds of held-out programs, as with a network that has learned little."""

    def __post_init__(self) -> None:
        require_ranges(self, WriterError, "")
        if self.heads % 2 or self.width % self.heads:
            raise WriterError(
                f"heads is {self.heads} with width {self.width}; valid: an even number that "
                "divides the width"
            )
