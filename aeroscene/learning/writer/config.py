"""Numbers of the writer's network."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from aeroscene.ranges import Range, require_ranges
from aeroscene.scene import SceneError


class WriterError(SceneError):
    """A writer that cannot be used; one line saying what is wrong and what is valid."""


@dataclass(frozen=True, kw_only=True)
class WriterCfg:
    """The network."""

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
    """What is less likely than this share of the likeliest is never drawn (min-p, Nguyen et al.
    2024); all else as often as the network has it. With more, scenes would be nearer to those
    trained on than other scenes of the grammar are. Training makes it less where too much of
    held-out programs would never be drawn, as of a network that has learnt little."""

    def __post_init__(self) -> None:
        require_ranges(self, WriterError, "")
        if self.heads % 2 or self.width % self.heads:
            raise WriterError(
                f"heads is {self.heads} with width {self.width}; valid: an even number that "
                "divides the width"
            )
