"""Configuration of the networks' trainings and of the whole procedure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from aeroscene.learning.training.rates import RateSchedule
from aeroscene.ranges import Range, require_ranges
from aeroscene.scene import SceneError

Preset = Literal["default", "paper", "progressive"]


class TrainingError(SceneError):
    """A training cannot begin or go on; one line has the reason and the way out."""


def require(*, ok: bool, name: str, value: object, valid: str) -> None:
    """Require that a field of a configuration is valid.

    Args:
        ok: True if it is.
        name: Name of the field.
        value: Its value.
        valid: Valid values, in words.

    Raises:
        TrainingError: If it is not.
    """
    if not ok:
        raise TrainingError(f"{name} is {value!r}; valid: {valid}")


_MOST = 2**31 - 1


@dataclass(frozen=True, kw_only=True)
class TrainCfg:
    """Settings of the training of a network."""

    batch_size: Annotated[int, Range(1, _MOST)] = 16
    """Scenes a step."""
    optimiser: Literal["adam", "adamw"] = "adamw"
    """AdamW decays weights apart from the gradient."""
    learning_rate: Annotated[float, Range(0.0, 1.0, is_above=True)] = 1.5e-3
    """At its highest."""
    weight_decay: Annotated[float, Range(0.0, 1.0)] = 0.01
    """Weight decay of AdamW, in units of the learning rate a step."""
    second_decay: float = 0.999
    """Decay of the mean squares of the gradients (beta_2)."""
    schedule: RateSchedule = "cooldown"
    """Course of the learning rate over the training."""
    warmup_steps: Annotated[int, Range(0, _MOST)] = 200
    """Steps over which the learning rate grows from nothing."""
    cooldown_share: Annotated[float, Range(0.0, 1.0)] = 0.5
    """Share of the training at its end in which the rate of `cooldown` falls."""
    clip_norm: Annotated[float, Range(0.0, 1e6)] = 1.0
    """Longest gradient; 0 leaves gradients as they are."""
    average_decay: float = 0.999
    """Decay of the moving average that generates; 0 generates with the last weights."""
    prior_steps: Annotated[int, Range(1, _MOST)] = 400
    """Steps of the semantic prior, where it is trained."""
    precision: Literal["auto", "single", "mixed"] = "auto"
    """`mixed` multiplies matrices in bfloat16; `auto` does so on a GPU only, since processors
    without units for it take longer."""
    is_compiled: bool = False
    """True lets `torch.compile` turn the network into fused kernels, which takes a minute at the
    start and pays on a GPU. It needs a C++ compiler."""
    keep: Literal["best", "last"] = "best"
    """Weights that the checkpoint has: those with the least held-out loss, or the last."""
    look_steps: Annotated[int, Range(1, _MOST)] = 250
    """Steps between two measurements on held-out scenes; one takes as long as a step or two."""
    scene_uses: Annotated[int, Range(1, _MOST)] = 32
    """Average number of uses of a scene of the stream before another takes its place. A batch of 16
    then needs a new scene every two steps; a worker makes two a second."""
    seed: Annotated[int, Range(0, _MOST)] = 0
    """Decides initial weights, batches, times and noise."""

    def __post_init__(self) -> None:
        require_ranges(self, TrainingError, "")
        for name in ("average_decay", "second_decay"):
            value = getattr(self, name)
            require(ok=0 <= value < 1, name=name, value=value, valid="0 to below 1")


@dataclass(frozen=True, slots=True)
class Budget:
    """Length of a training in steps or seconds, whichever ends first.

    Raises:
        TrainingError: If both are None, or one is out of range.
    """

    steps: int | None = None
    seconds: float | None = None

    def __post_init__(self) -> None:
        if self.steps is None and self.seconds is None:
            raise TrainingError("training has no end; valid: a number of steps or of minutes")
        if self.steps is not None:
            require(ok=self.steps >= 1, name="steps", value=self.steps, valid="1 or more")
        if self.seconds is not None:
            # A user gives minutes.
            minutes = self.seconds / 60
            require(ok=minutes > 0, name="minutes", value=minutes, valid="more than 0")

    def share(self, step: int, seconds: float) -> float:
        """Return the share of the training that is done; 1 or more at its end.

        Args:
            step: Steps done.
            seconds: Seconds spent.
        """
        # Whichever is further along ends the training.
        by_steps = 0.0 if self.steps is None else step / self.steps
        by_time = 0.0 if self.seconds is None else seconds / self.seconds
        return max(by_steps, by_time)
