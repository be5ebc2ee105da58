"""`state.safetensors`: a training as it stands, to go on from exactly there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import msgspec
from safetensors import SafetensorError, safe_open
from safetensors.torch import save
from torch import Tensor

from aeroscene.files import replacing
from aeroscene.learning.training.checkpoint import (
    PARTS,
    CheckpointError,
    CheckpointFacts,
    Part,
    Weights,
    under,
)
from aeroscene.learning.training.loop import DenoiserTraining

STATE = "state.safetensors"
VERSION = 1

_KEY = "aeroscene-training"
_MODEL, _AVERAGE, _MOMENTS, _PARTS = "model.", "average.", "moments.", "parts."
_BEST = "best."


class _Head(msgspec.Struct):
    version: int
    step: int
    seconds: float
    facts: CheckpointFacts
    best_step: int = 0
    best_loss: float | None = None


@dataclass(frozen=True)
class TrainingState:
    """Content of a training's state file."""

    path: Path
    facts: CheckpointFacts
    step: int
    seconds: float
    tensors: Mapping[str, Tensor]
    best_step: int = 0
    best_loss: float | None = None
    """Least held-out loss so far; None where no step was looked at."""

    @property
    def parts(self) -> dict[Part, Weights]:
        """Weights of the parts that are trained already."""
        kept = under(self.tensors, _PARTS)
        found: dict[Part, Weights] = {part: under(kept, f"{part}.") for part in PARTS}
        return {part: weights for part, weights in found.items() if weights}

    @property
    def has_denoiser(self) -> bool:
        """Whether the denoiser's training had begun."""
        return any(name.startswith(_MODEL) for name in self.tensors)

    def restore(self, training: DenoiserTraining) -> None:
        """Put a training where this one was.

        Raises:
            CheckpointError: If it is of another model.
        """
        try:
            training.model.load_state_dict(under(self.tensors, _MODEL))
            training.average.load(under(self.tensors, _AVERAGE))
        except (RuntimeError, KeyError) as error:
            detail = str(error).splitlines()[-1].strip()
            raise CheckpointError(
                f"state {str(self.path)!r} is of another model ({detail}), "
                "valid: the configuration that it was begun with, or another folder"
            ) from None
        moments = under(self.tensors, _MOMENTS)
        for name, parameter in training.model.named_parameters():
            kept = under(moments, f"{name}|")
            if kept:
                # Copies beside the parameter: the optimiser writes into them. Its count of steps
                # stays single precision, as it made it.
                training.optimiser.state[parameter] = {
                    key: value.to(training.device) for key, value in kept.items()
                }
        training.step, training.seconds = self.step, self.seconds
        if self.best_loss is not None:
            kept = under(self.tensors, _BEST)
            weights = {name: value.to(training.device) for name, value in kept.items()}
            training.best.offer(self.best_step, self.best_loss, weights)


def write_state(
    path: Path,
    facts: CheckpointFacts,
    training: DenoiserTraining | None,
    parts: Mapping[Part, Weights],
) -> None:
    """Write a training, whole or not at all: the denoiser's, where it has begun, and other parts.

    Raises:
        OSError: If it cannot be written.
    """
    tensors = {
        f"{_PARTS}{part}.{name}": value
        for part, weights in parts.items()
        for name, value in weights.items()
    }
    if training is not None:
        tensors |= {f"{_MODEL}{k}": v for k, v in training.model.state_dict().items()}
        tensors |= {f"{_AVERAGE}{k}": v for k, v in training.average.weights.items()}
        tensors |= {f"{_BEST}{k}": v for k, v in training.best.weights.items()}
        for name, parameter in training.model.named_parameters():
            state = training.optimiser.state.get(parameter, {})
            tensors |= {f"{_MOMENTS}{name}|{key}": value for key, value in state.items()}
    step, seconds = (0, 0.0) if training is None else (training.step, training.seconds)
    head = _Head(VERSION, step, seconds, facts)
    if training is not None and training.best.step:
        head.best_step, head.best_loss = training.best.step, training.best.loss
    plain = {name: value.detach().cpu().contiguous().clone() for name, value in tensors.items()}
    data = save(plain, metadata={_KEY: msgspec.json.encode(head).decode()})
    with replacing(path) as file:
        file.write(data)


def read_state(path: Path) -> TrainingState | None:
    """The training that a file holds, None where there is no file.

    Raises:
        CheckpointError: If it is damaged or of another version.
    """
    if not path.exists():
        return None
    try:
        with safe_open(path, framework="pt", device="cpu") as file:
            text = (file.metadata() or {}).get(_KEY, "")
            tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
        head = msgspec.json.decode(text, type=_Head)
    except (OSError, SafetensorError, msgspec.DecodeError) as error:
        raise CheckpointError(
            f"state {str(path)!r} is truncated or no state of a training ({error}), "
            "valid: as aeroscene train has written it; delete it to train anew"
        ) from None
    if head.version != VERSION:
        raise CheckpointError(
            f"state {str(path)!r} is of version {head.version}, valid: {VERSION}; "
            "delete it to train anew"
        )
    return TrainingState(
        path, head.facts, head.step, head.seconds, tensors, head.best_step, head.best_loss
    )
