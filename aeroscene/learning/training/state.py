"""`state.safetensors`: the full state of a training, to continue from exactly there.

It holds weights, their average, the best average, and the optimiser's moments, all in the precision
in which they were computed. A rounded state would take other steps.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import msgspec
from safetensors import safe_open
from safetensors.torch import save
from torch import Tensor

from aeroscene.files import replacing
from aeroscene.learning.training.checkpoint import Weights, under
from aeroscene.learning.training.checkpoint_facts import (
    PARTS,
    CheckpointError,
    CheckpointFacts,
    Part,
)
from aeroscene.learning.training.loop import PartTraining
from aeroscene.learning.training.state_head import KEY, VERSION, PartHead, StateHead, read_head

_MODEL, _AVERAGE, _MOMENTS, _BEST = "model.", "average.", "moments.", "best."
_PARTS = "parts."


@dataclass(frozen=True)
class TrainingState:
    """Content of a training's state file."""

    path: Path
    facts: CheckpointFacts
    heads: Mapping[Part, PartHead]
    """Progress of each part that is trained step by step."""
    tensors: Mapping[str, Tensor]

    @property
    def parts(self) -> dict[Part, Weights]:
        """Weights of finished parts: taken, or trained in one go."""
        kept = under(self.tensors, _PARTS)
        found: dict[Part, Weights] = {part: under(kept, f"{part}.") for part in PARTS}
        return {part: weights for part, weights in found.items() if weights}

    def restore(self, part: Part, training: PartTraining) -> None:
        """Set a part's training to this state.

        Raises:
            CheckpointError: If the state is of another model.
        """
        tensors, head = under(self.tensors, f"{part}."), self.heads[part]
        try:
            training.model.load_state_dict(under(tensors, _MODEL))
            training.average.load(under(tensors, _AVERAGE))
        except (RuntimeError, KeyError) as error:
            detail = str(error).splitlines()[-1].strip()
            raise CheckpointError(
                f"state {str(self.path)!r} is of another model ({detail}); "
                "valid: the configuration that it was begun with, or another folder"
            ) from None
        moments = under(tensors, _MOMENTS)
        for name, parameter in training.model.named_parameters():
            kept = under(moments, f"{name}|")
            if kept:
                # Copied to the parameter's device, because the optimiser writes into them. Its
                # count of steps stays in single precision, as it made it.
                training.optimiser.state[parameter] = {
                    key: value.to(training.device) for key, value in kept.items()
                }
        training.step, training.seconds = head.step, head.seconds
        if head.best_loss is not None:
            kept = under(tensors, _BEST)
            weights = {name: value.to(training.device) for name, value in kept.items()}
            training.best.offer(head.best_step, head.best_loss, weights)


def write_state(
    path: Path,
    facts: CheckpointFacts,
    trainings: Mapping[Part, PartTraining],
    parts: Mapping[Part, Weights],
) -> None:
    """Write a training, whole or not at all.

    Args:
        path: File to write.
        facts: Facts, as a checkpoint has them.
        trainings: Parts that have begun.
        parts: Weights of finished parts.

    Raises:
        OSError: If it cannot be written.
    """
    tensors = {
        f"{_PARTS}{part}.{name}": value
        for part, weights in parts.items()
        for name, value in weights.items()
    }
    for part, training in trainings.items():
        tensors |= {f"{part}.{name}": value for name, value in _tensors(training).items()}
    heads: dict[Part, PartHead] = {part: _head(training) for part, training in trainings.items()}
    plain = {name: value.detach().cpu().contiguous().clone() for name, value in tensors.items()}
    head = msgspec.json.encode(StateHead(VERSION, heads, facts)).decode()
    data = save(plain, metadata={KEY: head})
    with replacing(path) as file:
        file.write(data)


def _head(training: PartTraining) -> PartHead:
    best = training.best
    # Step 0 means that nothing was measured yet.
    best_loss = best.loss if best.step else None
    return PartHead(
        step=training.step, seconds=training.seconds, best_step=best.step, best_loss=best_loss
    )


def _tensors(training: PartTraining) -> dict[str, Tensor]:
    tensors = {f"{_MODEL}{k}": v for k, v in training.model.state_dict().items()}
    tensors |= {f"{_AVERAGE}{k}": v for k, v in training.average.weights.items()}
    tensors |= {f"{_BEST}{k}": v for k, v in training.best.weights.items()}
    for name, parameter in training.model.named_parameters():
        state = training.optimiser.state.get(parameter, {})
        tensors |= {f"{_MOMENTS}{name}|{key}": value for key, value in state.items()}
    return tensors


def read_state(path: Path) -> TrainingState | None:
    """Read the training that a file holds; None if there is no file.

    Raises:
        CheckpointError: If it is damaged or of another version.
    """
    head = read_head(path)
    if head is None:
        return None
    with safe_open(path, framework="pt", device="cpu") as file:
        tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
    return TrainingState(path, head.facts, head.parts, tensors)
