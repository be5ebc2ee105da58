"""What a checkpoint says of itself, and whether its file is whole: read without PyTorch.

PyTorch takes seconds and 200 MB, which a file that is refused should not cost.
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any, BinaryIO, Literal, get_args

import msgspec
from safetensors import SafetensorError, safe_open

from aeroscene.files import open_regular
from aeroscene.learning.wishes import Wish
from aeroscene.scene import SceneError
from aeroscene.scene.catalogue import CATALOGUE

FORMAT = "aeroscene-checkpoint"
VERSION = 2
_FLAT_VERSION = 4
"""First version whose lists are in order of place, in the axes of the site."""
FLAT_PRESETS = ("paper", "progressive")
"""Presets that have scenes as the paper does."""

Part = Literal["writer", "contents", "denoiser", "prior"]
PARTS: tuple[Part, ...] = get_args(Part)
_MOST_HEAD_BYTES = 8 << 20
"""Longest header; ours has the vocabulary and names of weights, together 2 MB."""
KEY = "aeroscene"
_CHUNK_BYTES = 1 << 20
_TORCH_NAMES = {
    "BOOL": "torch.bool",
    "U8": "torch.uint8",
    "I8": "torch.int8",
    "I16": "torch.int16",
    "I32": "torch.int32",
    "I64": "torch.int64",
    "F16": "torch.float16",
    "F32": "torch.float32",
    "F64": "torch.float64",
}
"""Types of tensors as safetensors and PyTorch name them; the digest has the latter."""


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


def category_names() -> tuple[str, ...]:
    """The catalogue's categories in the order of their numbers."""
    return tuple(CATALOGUE[number].name for number in sorted(CATALOGUE))


def read_facts(path: Path, *, any_catalogue: bool = False) -> CheckpointFacts:
    """Facts of a checkpoint, after a check that its weights are those that were written.

    Args:
        path: File of the checkpoint.
        any_catalogue: Whether the checkpoint may have the categories of an earlier catalogue.

    Raises:
        CheckpointError: If it is missing, truncated, damaged, of another version or, unless
            `any_catalogue`, of other categories.
    """
    try:
        # Before safetensors, whose errors do not name what is missing.
        require_short_head(path)
        with safe_open(path, framework="np") as file:
            facts = _facts(path, (file.metadata() or {}).get(KEY, ""))
        if not any_catalogue:
            _check_categories(path, facts)
        digest = _file_digest(path)
    except OSError as error:
        reason = (error.strerror or type(error).__name__).lower()
        raise CheckpointError(
            f"checkpoint {str(path)!r} cannot be read ({reason}); "
            "valid: a .safetensors file that aeroscene train has written"
        ) from None
    except (SafetensorError, msgspec.DecodeError) as error:
        raise CheckpointError(
            f"checkpoint {str(path)!r} is truncated or no checkpoint ({error}); valid: a "
            ".safetensors file as aeroscene train has written it; copy it again"
        ) from None
    if facts.digest != digest:
        raise CheckpointError(
            f"checkpoint {str(path)!r} is damaged (its weights are not those that were written); "
            "valid: the file as it was made; copy it again"
        )
    return facts


def require_short_head(path: Path) -> None:
    """Refuse a file of tensors whose header is longer than any of ours.

    Raises:
        OSError: If it cannot be read.
        SafetensorError: If the header is too long.
    """
    with open_regular(path) as file:
        n_bytes = int.from_bytes(file.read(8), "little")
    if n_bytes > _MOST_HEAD_BYTES:
        raise SafetensorError(f"its header claims {n_bytes} bytes")


class _TensorHead(msgspec.Struct):
    """Type, shape and place of a tensor in the file."""

    dtype: str
    shape: tuple[int, ...]
    data_offsets: tuple[int, int]


def read_shapes(path: Path) -> dict[str, tuple[int, ...]]:
    """Shapes of the tensors in a checkpoint that `read_facts` has read, by name."""
    with open_regular(path) as file:
        return {name: head.shape for name, head in _tensor_heads(file)[0]}


def _tensor_heads(file: BinaryIO) -> tuple[list[tuple[str, _TensorHead]], int]:
    """Heads of the tensors in order of their names, and where the first tensor begins."""
    n_bytes = int.from_bytes(file.read(8), "little")
    heads = msgspec.json.decode(file.read(n_bytes), type=dict[str, msgspec.Raw])
    heads.pop("__metadata__", None)
    return [
        (name, msgspec.json.decode(raw, type=_TensorHead)) for name, raw in sorted(heads.items())
    ], 8 + n_bytes


def _file_digest(path: Path) -> str:
    """Digest of the tensors in a file as `write_checkpoint` makes it, a piece at a time.

    safetensors has checked offsets and shapes against the file when it was opened.
    """
    digest = hashlib.sha256()
    with open_regular(path) as file:
        heads, first = _tensor_heads(file)
        for name, head in heads:
            dtype = _TORCH_NAMES.get(head.dtype, head.dtype)
            digest.update(tensor_title(name, dtype, head.shape))
            begin, end = head.data_offsets
            file.seek(first + begin)
            _feed(digest, file, end - begin)
    return digest.hexdigest()


def tensor_title(name: str, dtype: str, shape: tuple[int, ...]) -> bytes:
    """The bytes in a checkpoint's digest that come before those of a tensor."""
    return f"{name} {dtype} {shape}".encode()


def _feed(digest: Any, file: BinaryIO, n_bytes: int) -> None:
    while n_bytes > 0 and (piece := file.read(min(n_bytes, _CHUNK_BYTES))):
        digest.update(piece)
        n_bytes -= len(piece)


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
            f"{head.get('format')!r}); valid: {FORMAT!r}, as aeroscene train writes it"
        )
    valid = version_of(head.get("preset"))
    if head.get("version") != valid:
        raise CheckpointError(
            f"checkpoint {str(path)!r} is of version {head.get('version')!r}; valid: {valid}; "
            f"it was made by AeroScene {head.get('code')}: use that, or train anew"
        )
    try:
        facts = msgspec.json.decode(text, type=CheckpointFacts)
    except msgspec.DecodeError as error:
        raise CheckpointError(
            f"checkpoint {str(path)!r} is damaged ({error}); valid: the file as it was made"
        ) from None
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
        f"({example}); valid: the {len(known)} of this catalogue; aeroscene train --begin FILE "
        "makes a model of them from one of the preset 'default'"
    )
