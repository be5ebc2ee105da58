"""Facts that a checkpoint states, and a check that its file is whole, without PyTorch.

PyTorch takes seconds and 200 MB, which a file that is refused should not cost. The digest of all
weights is computed from the bytes of the file, piece by piece.
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
"""First format version whose lists are in order of place, in the axes of the site."""
FLAT_PRESETS = ("paper", "progressive")
"""Presets whose scenes are flat lists of boxes, as the paper's are."""

Part = Literal["writer", "contents", "denoiser", "prior"]
PARTS: tuple[Part, ...] = get_args(Part)
_MOST_HEAD_BYTES = 8 << 20
"""Longest header. Ours has the vocabulary and names of weights, together 2 MB. A longer one would
fill the memory."""
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
"""Types of tensors as safetensors and as PyTorch name them; the digest has the latter."""


def version_of(preset: object) -> int:
    """Return the format version of the checkpoints of a preset."""
    return _FLAT_VERSION if preset in FLAT_PRESETS else VERSION


class CheckpointError(SceneError):
    """A checkpoint cannot be used; one line has the reason and the way out."""


class DataSource(msgspec.Struct, frozen=True, kw_only=True):
    """Training data of a model."""

    name: str
    """Name of the folder or file, without its path."""
    digest: str
    """Digest of the whole training data, hexadecimal."""
    n_scenes: int
    """Number of scenes with a program, mirror images of layouts included."""
    wishes: tuple[Wish, ...] = ()
    """Contents of a sample of the training scenes. Open fields of a request are drawn from these;
    without any they are drawn as in the corpus."""
    is_corpus: bool = True
    """True if scenes have at most as many landing areas as the corpus draws for each."""
    stream: str = ""
    """Sources and first number of the grammar's scenes after these; empty without a stream."""


class CheckpointFacts(msgspec.Struct, frozen=True, kw_only=True):
    """Facts that a checkpoint stores about itself."""

    format: str = FORMAT
    version: int = VERSION
    preset: str
    configs: dict[str, dict[str, Any]]
    """Every configuration by its section, as in a configuration file."""
    vocabulary: str
    """Kinds of tokens, or looks of objects, as JSON of their own."""
    categories: tuple[str, ...]
    """Names of the categories in the order of their numbers, from 1."""
    is_foreign: bool = False
    """True if the categories are those of a foreign layout file, not our catalogue's."""
    data: DataSource
    code: str
    """Version of the code that trained it."""
    training: dict[str, Any]
    """Figures of the training: steps, seconds, losses, device."""
    digest: str = ""
    """Digest of all weights, hexadecimal; computed when the file is written."""


def category_names() -> tuple[str, ...]:
    """Return the catalogue's categories in the order of their numbers."""
    return tuple(CATALOGUE[number].name for number in sorted(CATALOGUE))


def read_facts(path: Path, *, any_catalogue: bool = False) -> CheckpointFacts:
    """Read the facts of a checkpoint, after a check that its weights are as they were written.

    Args:
        path: File of the checkpoint.
        any_catalogue: True accepts the categories of an earlier catalogue.

    Raises:
        CheckpointError: If it is missing, truncated, damaged, of another version or, unless
            `any_catalogue`, of other categories.
    """
    try:
        # Before safetensors opens it, because errors of safetensors do not name a missing file.
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
        # A safetensors file begins with the length of its header, eight bytes, little-endian.
        n_bytes = int.from_bytes(file.read(8), "little")
    if n_bytes > _MOST_HEAD_BYTES:
        raise SafetensorError(f"its header claims {n_bytes} bytes")


class _TensorHead(msgspec.Struct):
    """Type, shape and byte range of a tensor in the file."""

    dtype: str
    shape: tuple[int, ...]
    data_offsets: tuple[int, int]


def read_shapes(path: Path) -> dict[str, tuple[int, ...]]:
    """Return the shapes of the tensors by name, of a checkpoint that `read_facts` has checked."""
    with open_regular(path) as file:
        return {name: head.shape for name, head in _tensor_heads(file)[0]}


def _tensor_heads(file: BinaryIO) -> tuple[list[tuple[str, _TensorHead]], int]:
    """Return the heads of the tensors sorted by name, and the offset of the first tensor."""
    n_bytes = int.from_bytes(file.read(8), "little")
    heads = msgspec.json.decode(file.read(n_bytes), type=dict[str, msgspec.Raw])
    heads.pop("__metadata__", None)
    return [
        (name, msgspec.json.decode(raw, type=_TensorHead)) for name, raw in sorted(heads.items())
    ], 8 + n_bytes


def _file_digest(path: Path) -> str:
    """Compute the digest of the tensors in a file, a piece at a time.

    It equals the digest of `write_checkpoint`. safetensors has checked offsets and shapes against
    the file when it was opened.
    """
    digest = hashlib.sha256()
    with open_regular(path) as file:
        heads, first = _tensor_heads(file)
        for name, head in heads:
            dtype = _TORCH_NAMES.get(head.dtype, head.dtype)
            # Name, type and shape are part of the digest: a renamed tensor is a damaged file.
            digest.update(tensor_title(name, dtype, head.shape))
            begin, end = head.data_offsets
            file.seek(first + begin)
            _feed(digest, file, end - begin)
    return digest.hexdigest()


def tensor_title(name: str, dtype: str, shape: tuple[int, ...]) -> bytes:
    """Return the bytes that precede those of a tensor in a checkpoint's digest."""
    return f"{name} {dtype} {shape}".encode()


def _feed(digest: Any, file: BinaryIO, n_bytes: int) -> None:
    while n_bytes > 0 and (piece := file.read(min(n_bytes, _CHUNK_BYTES))):
        digest.update(piece)
        n_bytes -= len(piece)


class _Head(msgspec.Struct):
    """Fields that decide if the rest can be read."""

    format: str = ""
    version: int = 0
    preset: str = ""
    code: str = ""


def _facts(path: Path, text: str) -> CheckpointFacts:
    # A file of another version may lack fields, so format and version are read alone first.
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
    # Deeply nested JSON raises a RecursionError.
    except (msgspec.DecodeError, RecursionError):
        return {}
    return {name: getattr(head, name) for name in head.__struct_fields__}


def _check_categories(path: Path, facts: CheckpointFacts) -> None:
    known = category_names()
    if facts.is_foreign or facts.categories == known:
        return
    # An example helps more than two lists of seventy names.
    strange = [name for name in facts.categories if name not in known]
    example = f"it has {strange[0]!r}" if strange else "they are others, or in another order"
    raise CheckpointError(
        f"checkpoint {str(path)!r} was trained with {len(facts.categories)} other categories "
        f"({example}); valid: the {len(known)} of this catalogue; aeroscene train --begin FILE "
        "makes a model of them from one of the preset 'default'"
    )
