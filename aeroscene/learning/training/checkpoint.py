"""A trained model in one file: weights by part, and everything needed to run them.

    FILE.safetensors
      tensors    writer.*, denoiser.*, prior.*: weights by their part's prefix;
                 known.*: statistics and structure of what it was trained on
      metadata   "aeroscene": JSON with format, version, preset, configurations, vocabulary,
                 what it was trained on, by which code, with which figures

A part may be missing: a training that was stopped has not all of them yet.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Literal, get_args

import msgspec
import numpy as np
import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save
from torch import Tensor, nn

from aeroscene.files import open_regular, replacing
from aeroscene.learning.paper.channels import FlatStatistics
from aeroscene.learning.tokens.skeleton import Wish
from aeroscene.learning.writer.language import Language
from aeroscene.scene import SceneError
from aeroscene.scene.catalogue import CATALOGUE

FORMAT = "aeroscene-checkpoint"
VERSION = 2
_FLAT_VERSION = 3
"""First version in which the paper's presets standardise by category and draw contents first."""
FLAT_PRESETS = ("paper", "progressive")
"""Presets that have scenes as the paper does."""

Part = Literal["writer", "contents", "denoiser", "prior"]
PARTS: tuple[Part, ...] = get_args(Part)
Weights = Mapping[str, Tensor]
Known = Language | FlatStatistics
"""What a model knows of its data beside weights: ours a language, the paper's statistics."""

_MOST_HEAD_BYTES = 8 << 20
"""Longest header; ours has the vocabulary and names of weights, together 2 MB."""
_KEY = "aeroscene"
_KNOWN = "known."


def version_of(preset: object) -> int:
    """Version of the checkpoints of a preset."""
    return _FLAT_VERSION if preset in FLAT_PRESETS else VERSION


class CheckpointError(SceneError):
    """A checkpoint that cannot be used; one line saying why and what would do."""


class DataSource(msgspec.Struct, frozen=True, kw_only=True):
    """Data that a model was trained on."""

    name: str
    """Folder or file, without its place."""
    digest: str
    """Digest of everything that was trained on, hexadecimal."""
    n_scenes: int
    """Scenes that have a program, mirror images of layouts among them."""
    wishes: tuple[Wish, ...] = ()
    """Contents of scenes trained on, a sample of them: what is left open in a request is drawn from
    these, and without them as the corpus draws it."""
    is_corpus: bool = True
    """Whether scenes have as many landing areas at most as the corpus draws for each."""
    stream: str = ""
    """What goes on after those scenes, where the grammar does: its sources and first number."""


class CheckpointFacts(msgspec.Struct, frozen=True, kw_only=True):
    """Facts that a checkpoint stores about itself."""

    format: str = FORMAT
    version: int = VERSION
    preset: str
    configs: dict[str, dict[str, Any]]
    """Every configuration by its section, as in a configuration file."""
    vocabulary: str
    """The kinds of tokens, or of objects, as JSON of their own."""
    categories: tuple[str, ...]
    """Names of the categories in the order of their numbers, from 1."""
    is_foreign: bool = False
    """Whether the categories are those of a foreign layout file, not our catalogue's."""
    data: DataSource
    code: str
    """Version of the code that trained it."""
    training: dict[str, Any]
    """Figures of the training: steps, seconds, losses, device."""
    digest: str = ""
    """Digest of all weights, hexadecimal; made when it is written."""


@dataclass(frozen=True)
class Checkpoint:
    """A trained model, on the processor, in single precision."""

    facts: CheckpointFacts
    parts: Mapping[Part, Weights]
    known: Known

    def weights_of(self, part: Part) -> Weights:
        """The weights of a part.

        Raises:
            CheckpointError: If it is missing.
        """
        if part not in self.parts:
            raise CheckpointError(
                f"checkpoint has no {part}, only {', '.join(self.parts) or 'nothing'}, valid: a "
                "training run to its end; aeroscene train --resume goes on with it"
            )
        return self.parts[part]

    def load_into(self, module: nn.Module, part: Part) -> None:
        """Give a module the weights of a part.

        Raises:
            CheckpointError: If the part is missing or was made for another module.
        """
        weights = dict(self.weights_of(part))
        try:
            module.load_state_dict(weights)
        except RuntimeError as error:
            detail = str(error).splitlines()[-1].strip()
            raise CheckpointError(
                f"checkpoint's {part} does not fit the configuration stored with it ({detail}), "
                "valid: weights and configuration of one training"
            ) from None


def category_names() -> tuple[str, ...]:
    """The catalogue's categories in the order of their numbers."""
    return tuple(CATALOGUE[number].name for number in sorted(CATALOGUE))


def write_checkpoint(
    path: Path,
    facts: CheckpointFacts,
    parts: Mapping[Part, Weights],
    known: Known,
    *,
    is_half: bool = True,
) -> None:
    """Write a checkpoint, whole or not at all.

    Weights take half precision on disk where `is_half`, what is known never; what is read back is
    single again.

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
    data = save(tensors, metadata={_KEY: msgspec.json.encode(facts).decode()})
    with replacing(path) as file:
        file.write(data)


def read_checkpoint(path: str | Path) -> Checkpoint:
    """Read and check a checkpoint.

    Raises:
        CheckpointError: If it is missing, truncated, damaged, of another version or of other
            categories.
    """
    path = Path(path)
    facts, tensors = _read(path)
    if facts.digest != _digest(tensors.items()):
        raise CheckpointError(
            f"checkpoint {str(path)!r} is damaged (its weights are not those that were written), "
            "valid: the file as it was made; copy it again"
        )
    single = {k: v.float() if v.dtype == torch.float16 else v for k, v in tensors.items()}
    parts: dict[Part, Weights] = {part: under(single, f"{part}.") for part in PARTS}
    found: dict[Part, Weights] = {part: weights for part, weights in parts.items() if weights}
    return Checkpoint(facts, found, _known(path, facts, tensors))


def under(tensors: Weights, prefix: str) -> dict[str, Tensor]:
    """The tensors whose names begin with a prefix, without it."""
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
            return FlatStatistics(**arrays)
        return Language.restored(facts.vocabulary, arrays)
    except (TypeError, KeyError, msgspec.DecodeError):
        raise CheckpointError(
            f"checkpoint {str(path)!r} lacks the statistics of its channels, "
            "valid: the file as aeroscene train has written it"
        ) from None


def _stored(value: Tensor, *, is_half: bool) -> Tensor:
    value = value.detach().cpu()
    if value.is_floating_point():
        value = value.half() if is_half else value.float()
    # A copy: safetensors refuses weights that two names share.
    return value.contiguous().clone()


def _read(path: Path) -> tuple[CheckpointFacts, dict[str, Tensor]]:
    """Facts first, so that the weights of another program are not even loaded."""
    try:
        # Before safetensors, whose errors do not name what is missing.
        _require_short_head(path)
        with safe_open(path, framework="pt", device="cpu") as file:
            facts = _facts(path, (file.metadata() or {}).get(_KEY, ""))
            return facts, {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
    except OSError as error:
        reason = (error.strerror or type(error).__name__).lower()
        raise CheckpointError(
            f"checkpoint {str(path)!r} cannot be read ({reason}), "
            "valid: a .safetensors file that aeroscene train has written"
        ) from None
    except SafetensorError as error:
        raise CheckpointError(
            f"checkpoint {str(path)!r} is truncated or no checkpoint ({error}), valid: a "
            ".safetensors file as aeroscene train has written it; copy it again"
        ) from None


def _require_short_head(path: Path) -> None:
    with open_regular(path) as file:
        n_bytes = int.from_bytes(file.read(8), "little")
    if n_bytes > _MOST_HEAD_BYTES:
        raise SafetensorError(f"its header claims {n_bytes} bytes")


class _Head(msgspec.Struct):
    """What says whether the rest can be read."""

    format: str = ""
    version: int = 0
    preset: str = ""
    code: str = ""


def _facts(path: Path, text: str) -> CheckpointFacts:
    head = _head(text)
    if head.get("format") != FORMAT:
        raise CheckpointError(
            f"checkpoint {str(path)!r} holds weights of another program (format is "
            f"{head.get('format')!r}), valid: {FORMAT!r}, as aeroscene train writes it"
        )
    valid = version_of(head.get("preset"))
    if head.get("version") != valid:
        raise CheckpointError(
            f"checkpoint {str(path)!r} is of version {head.get('version')!r}, valid: {valid}; "
            f"it was made by AeroScene {head.get('code')}: use that, or train anew"
        )
    try:
        facts = msgspec.json.decode(text, type=CheckpointFacts)
    except msgspec.DecodeError as error:
        raise CheckpointError(
            f"checkpoint {str(path)!r} is damaged ({error}), valid: the file as it was made"
        ) from None
    _check_categories(path, facts)
    return facts


def _head(text: str) -> dict[str, Any]:
    try:
        head = msgspec.json.decode(text, type=_Head)
    except (msgspec.DecodeError, RecursionError):
        return {}
    return {name: getattr(head, name) for name in head.__struct_fields__}


def _check_categories(path: Path, facts: CheckpointFacts) -> None:
    known = category_names()
    if facts.is_foreign or facts.categories == known:
        return
    strange = [name for name in facts.categories if name not in known]
    example = f"it has {strange[0]!r}" if strange else "they are others, or in another order"
    raise CheckpointError(
        f"checkpoint {str(path)!r} was trained with {len(facts.categories)} other categories "
        f"({example}), valid: the {len(known)} of this catalogue; train anew with aeroscene train"
    )


def _digest(tensors: Iterable[tuple[str, Tensor]]) -> str:
    digest = hashlib.sha256()
    for name, value in sorted(tensors):
        digest.update(f"{name} {value.dtype} {tuple(value.shape)}".encode())
        digest.update(value.contiguous().view(-1).view(torch.uint8).numpy().tobytes())
    return digest.hexdigest()
