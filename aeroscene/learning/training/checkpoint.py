"""A trained model in one file: weights by part, and everything needed to run them.

    FILE.safetensors
      tensors    writer.*, contents.*, denoiser.*, prior.*: weights by their part's prefix;
                 known.*: statistics and structure of its training data
      metadata   "aeroscene": JSON with format, version, preset, configurations, vocabulary,
                 training data, version of the code, figures

A part may be missing, because a stopped training does not have all of them yet. safetensors holds
tensors and text only, so that a file from a stranger cannot run code when it is read.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import torch
from safetensors import safe_open
from safetensors.torch import save
from torch import Tensor, nn

from aeroscene.files import replacing
from aeroscene.learning.paper.channels import FlatStatistics
from aeroscene.learning.paper.looks import Looks
from aeroscene.learning.training.checkpoint_facts import (
    FLAT_PRESETS,
    KEY,
    PARTS,
    CheckpointError,
    CheckpointFacts,
    Part,
    read_facts,
    tensor_title,
    version_of,
)
from aeroscene.learning.writer.language import Language

Weights = Mapping[str, Tensor]
Known = Language | FlatStatistics
"""Knowledge of the data beside weights: our language, or the paper's statistics."""

_KNOWN = "known."


@dataclass(frozen=True)
class Checkpoint:
    """A trained model, on the processor, in single precision."""

    facts: CheckpointFacts
    parts: Mapping[Part, Weights]
    known: Known

    def weights_of(self, part: Part) -> Weights:
        """Return the weights of a part.

        Raises:
            CheckpointError: If it is missing.
        """
        if part not in self.parts:
            raise CheckpointError(
                f"checkpoint has no {part}, only {', '.join(self.parts) or 'nothing'}; valid: a "
                "training run to its end; aeroscene train --resume goes on with it"
            )
        return self.parts[part]

    def load_into(self, module: nn.Module, part: Part) -> None:
        """Load the weights of a part into a module.

        Raises:
            CheckpointError: If the part is missing or was made for another module.
        """
        weights = dict(self.weights_of(part))
        try:
            module.load_state_dict(weights)
        except RuntimeError as error:
            detail = str(error).splitlines()[-1].strip()
            raise CheckpointError(
                f"checkpoint's {part} does not fit the configuration stored with it ({detail}); "
                "valid: weights and configuration of one training"
            ) from None


def write_checkpoint(
    path: Path,
    facts: CheckpointFacts,
    parts: Mapping[Part, Weights],
    known: Known,
    *,
    is_half: bool = True,
) -> None:
    """Write a checkpoint, whole or not at all.

    Args:
        path: File to write.
        facts: Facts of the checkpoint; version and digest are filled in here.
        parts: Weights by part.
        known: Knowledge of the training data, always in full precision.
        is_half: True stores weights in half precision. Reading gives single precision again.

    Raises:
        OSError: If it cannot be written.
    """
    tensors = {
        f"{part}.{name}": _stored(value, is_half=is_half)
        for part, weights in parts.items()
        for name, value in weights.items()
    }
    tensors |= {f"{_KNOWN}{k}": v for k, v in _known_tensors(known).items()}
    version = version_of(facts.preset)
    facts = msgspec.structs.replace(facts, version=version, digest=_digest(tensors.items()))
    data = save(tensors, metadata={KEY: msgspec.json.encode(facts).decode()})
    with replacing(path) as file:
        file.write(data)


def read_checkpoint(path: str | Path, *, any_catalogue: bool = False) -> Checkpoint:
    """Read and check a checkpoint.

    Args:
        path: File of the checkpoint.
        any_catalogue: True accepts the categories of an earlier catalogue.

    Raises:
        CheckpointError: If it is missing, truncated, damaged, of another version or, unless
            `any_catalogue`, of other categories.
    """
    path = Path(path)
    # The digest is checked before any tensor is used.
    facts = read_facts(path, any_catalogue=any_catalogue)
    with safe_open(path, framework="pt", device="cpu") as file:
        tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
    single = {k: v.float() if v.dtype == torch.float16 else v for k, v in tensors.items()}
    parts: dict[Part, Weights] = {part: under(single, f"{part}.") for part in PARTS}
    found: dict[Part, Weights] = {part: weights for part, weights in parts.items() if weights}
    return Checkpoint(facts, found, _known(path, facts, tensors))


def under(tensors: Weights, prefix: str) -> dict[str, Tensor]:
    """Return the tensors whose names begin with a prefix, without it."""
    return {k.removeprefix(prefix): v for k, v in tensors.items() if k.startswith(prefix)}


def _known_tensors(known: Known) -> dict[str, Tensor]:
    if isinstance(known, Language):
        arrays = known.to_arrays()
    else:
        arrays = {field.name: getattr(known, field.name) for field in fields(known)}
    return {k: torch.from_numpy(np.ascontiguousarray(v)) for k, v in arrays.items()}


def _known(path: Path, facts: CheckpointFacts, tensors: Weights) -> Known:
    arrays: dict[str, Any] = {k: v.numpy() for k, v in under(tensors, _KNOWN).items()}
    try:
        if facts.preset in FLAT_PRESETS:
            # Looks are parsed here so that a damaged file is refused now, and
            # not when a scene is drawn.
            Looks.from_json(facts.vocabulary)
            return FlatStatistics(**arrays)
        return Language.restored(facts.vocabulary, arrays)
    except (TypeError, KeyError, ValueError, msgspec.DecodeError):
        raise CheckpointError(
            f"checkpoint {str(path)!r} lacks the statistics of its channels or the "
            "looks of its categories; valid: the file as aeroscene train has written it"
        ) from None


def _stored(value: Tensor, *, is_half: bool) -> Tensor:
    value = value.detach().cpu()
    if value.is_floating_point():
        value = value.half() if is_half else value.float()
    # A copy: safetensors refuses weights that two names share.
    return value.contiguous().clone()


def _digest(tensors: Iterable[tuple[str, Tensor]]) -> str:
    digest = hashlib.sha256()
    # Sorted, so that the order of the parts does not matter.
    for name, value in sorted(tensors):
        digest.update(tensor_title(name, str(value.dtype), tuple(value.shape)))
        digest.update(value.contiguous().view(-1).view(torch.uint8).numpy().tobytes())
    return digest.hexdigest()
