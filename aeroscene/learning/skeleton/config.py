"""Numbers of the skeleton model: its network and its training."""

from __future__ import annotations

from dataclasses import dataclass


class SkeletonError(ValueError):
    """A skeleton model that cannot be used; one line saying what is wrong and what is valid."""


@dataclass(frozen=True, kw_only=True)
class SkeletonCfg:
    """The network."""

    width: int = 160
    """Width of the recurrent state."""
    layers: int = 2
    """Recurrent layers of each stage."""
    kind_width: int = 64
    """Width of a kind's embedding."""
    dropout: float = 0.15
    """Share of activations that training switches off."""

    def __post_init__(self) -> None:
        _require("width", self.width, 8, 1024)
        _require("layers", self.layers, 1, 8)
        _require("kind_width", self.kind_width, 4, 512)
        _require("dropout", self.dropout, 0.0, 0.9)


@dataclass(frozen=True, kw_only=True)
class SkeletonTrainingCfg:
    """Settings of the network's training."""

    batch: int = 32
    """Scenes a step."""
    learning_rate: float = 2e-3
    """At the end of the warm-up; a cosine takes it to nothing."""
    weight_decay: float = 0.02
    """Weight decay of AdamW."""
    held_out: float = 0.1
    """Share of the skeletons that training does not see: the best weights on them are kept."""
    looks: int = 12
    """Number of evaluations on the held-out part."""
    seconds: float | None = 600.0
    """Longest training, by the clock that `train_skeleton` is given."""
    steps: int | None = None
    """Greatest number of steps."""

    def spent(self, step: int, seconds: float) -> float:
        """Share of the training that is behind after so many steps and seconds."""
        by_steps = 0.0 if self.steps is None else step / self.steps
        return by_steps if self.seconds is None else max(by_steps, seconds / self.seconds)

    def __post_init__(self) -> None:
        _require("batch", self.batch, 1, 4096)
        _require("learning_rate", self.learning_rate, 1e-6, 1.0)
        _require("weight_decay", self.weight_decay, 0.0, 1.0)
        _require("held_out", self.held_out, 0.0, 0.5)
        _require("looks", self.looks, 1, 1000)
        if self.steps is None and self.seconds is None:
            raise SkeletonError("seconds and steps are None, valid: a number for one of them")
        if self.seconds is not None:
            _require("seconds", self.seconds, 1e-3, 1e7)
        if self.steps is not None:
            _require("steps", self.steps, 1, 1e9)


def _require(name: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:
        raise SkeletonError(f"{name} is {value!r}, valid: {low:g} to {high:g}")
