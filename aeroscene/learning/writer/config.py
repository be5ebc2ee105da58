"""Numbers of the writer's network."""

from __future__ import annotations

from dataclasses import dataclass

from aeroscene.scene import SceneError


class WriterError(SceneError):
    """A writer that cannot be used; one line saying what is wrong and what is valid."""


@dataclass(frozen=True, kw_only=True)
class WriterCfg:
    """The network."""

    width: int = 160
    """Width of an element."""
    layers: int = 4
    """Blocks of attention and FFN."""
    heads: int = 4
    """Attention heads, even: half of them see kin alone."""
    ffn_ratio: int = 3
    """Hidden width of the FFN by `width`."""
    kind_width: int = 96
    """Width of a kind's embedding."""
    dropout: float = 0.1
    """Share of activations that training switches off."""
    least_share: float = 0.05
    """What is less likely than this share of the likeliest is never drawn (min-p, Nguyen et al.
    2024); all else as often as the network has it. With more, scenes would be nearer to those
    trained on than other scenes of the grammar are. Training makes it less where too much of
    held-out programs would never be drawn, as of a network that has learnt little."""

    def __post_init__(self) -> None:
        _require("width", self.width, 8, 1024)
        _require("layers", self.layers, 1, 16)
        _require("heads", self.heads, 2, 16)
        _require("ffn_ratio", self.ffn_ratio, 1, 8)
        _require("kind_width", self.kind_width, 4, 512)
        _require("dropout", self.dropout, 0.0, 0.9)
        _require("least_share", self.least_share, 0.0, 1.0)
        if self.heads % 2 or self.width % self.heads:
            raise WriterError(
                f"heads is {self.heads} with width {self.width}, valid: an even number that "
                "divides the width"
            )


def _require(name: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:
        raise WriterError(f"{name} is {value!r}, valid: {low:g} to {high:g}")
