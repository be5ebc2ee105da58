"""The corpus as a folder: a file for each scene, and a manifest that describes each one.

    DIR/manifest.json                 the scenes, with checksums
    DIR/scenes/corpus-0042.json.gz    scene 42
    DIR/journal.jsonl                 only while a build is under way, or after it was killed

A build of 1,016 scenes takes long and may be interrupted. Each finished scene is therefore appended
to the journal, and the next build continues from there. The manifest replaces the journal at the
end. Nothing in the folder depends on when, where or in which order it was made, so that two builds
can be compared byte for byte.
"""

from __future__ import annotations

import hashlib
from collections.abc import Container, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import msgspec

from aeroscene.corpus.corpus import CORPUS_SIZE
from aeroscene.corpus.provenance import curation_digest
from aeroscene.corpus.summary import SceneSummary, Split, summarise
from aeroscene.files import UnpackError, read_bounded, replacing
from aeroscene.scene import Scene, SceneError
from aeroscene.scene.io import read_scene, write_scene

FORMAT = "aeroscene-dataset"
VERSION = 1
MANIFEST = "manifest.json"
JOURNAL = "journal.jsonl"
SCENES = "scenes"
_MOST_BYTES = 32 << 20
"""Greatest length of a manifest, bytes; a manifest of 1,016 scenes has 0.5 MB."""


class DatasetError(SceneError):
    """A dataset that cannot be read or made; one line says where, what and what is valid."""


class SceneEntry(
    SceneSummary, frozen=True, kw_only=True, forbid_unknown_fields=True, omit_defaults=True
):
    """Entry of one scene in the manifest; in the corpus its index is its seed."""

    file: Annotated[str, msgspec.Meta(pattern=r"^scenes/[\w.-]+$")]
    """Path below the dataset's folder."""
    sha256: str
    """Digest of the file's bytes, hexadecimal."""
    sources: str
    """Digest of its origin: the code, see `aeroscene.corpus.provenance`, or model and code."""
    attempt: int = 0
    """Number of draws of the scene before this one that were rejected."""


class _Manifest(msgspec.Struct, forbid_unknown_fields=True):
    format: str
    version: int
    scenes: tuple[SceneEntry, ...]


@dataclass(frozen=True, slots=True)
class Dataset:
    """Scenes in a folder; a part of them is a `Dataset` too.

    Opening reads the manifest only. Scenes are read one by one, when they are asked for.
    """

    folder: Path
    entries: tuple[SceneEntry, ...]
    """Scenes, in the order of their numbers."""

    @property
    def title(self) -> str:
        """Name of the set in a sentence, in its messages and tables."""
        return "corpus"

    @property
    def place(self) -> Path:
        """Folder of the set."""
        return self.folder

    def of_split(self, split: Split) -> Dataset:
        """Select the scenes for training, or those for testing; their order stays."""
        return Dataset(self.folder, tuple(e for e in self.entries if e.split == split))

    def select(self, indices: Container[int]) -> Dataset:
        """Select the scenes whose numbers are among these, as far as they are there."""
        return Dataset(self.folder, tuple(e for e in self.entries if e.index in indices))

    def path(self, entry: SceneEntry) -> Path:
        """File of a scene; it may be missing while a build is under way."""
        return self.folder / entry.file

    def read(self, entry: SceneEntry) -> Scene:
        """Read and validate one scene.

        Raises:
            SceneError: If the file is missing, damaged, not the one that was listed, or no scene.
        """
        path = self.path(entry)
        scene = read_scene(path)
        # Reading has checked that it is a scene; this checks that it is the one that was made.
        if _sha256(path) != entry.sha256:
            raise DatasetError(
                f"scene file {str(path)!r} is not the one that the manifest lists (another "
                "sha256); valid: the file as it was made; aeroscene dataset build makes it again"
            )
        return scene

    def scenes(self) -> Iterator[Scene]:
        """Read every scene, in the order of the numbers.

        Raises:
            SceneError: As `read` does.
        """
        return (self.read(entry) for entry in self.entries)


def open_dataset(folder: str | Path) -> Dataset:
    """Open the dataset in a folder, whole or as far as its build has come.

    Raises:
        DatasetError: If there is none, or its manifest cannot be read.
    """
    folder = Path(folder)
    entries = read_entries(folder)
    if not entries:
        raise DatasetError(
            f"folder {str(folder)!r} holds no dataset ({MANIFEST} is missing); "
            "valid: a folder that aeroscene dataset build has made, or one of scene files"
        )
    return Dataset(folder, entries)


def shortfall(dataset: Dataset) -> str | None:
    """Describe in one line which scenes of the corpus a folder lacks.

    Args:
        dataset: Dataset of the corpus.

    Returns:
        The line, which names the command that makes the others; None if all scenes are there.
    """
    n_listed = len(dataset.entries)
    n_there = sum(dataset.path(entry).is_file() for entry in dataset.entries)
    if n_there == n_listed and n_there >= CORPUS_SIZE:
        return None
    said = f"folder {str(dataset.folder)!r} holds {n_there:,} of the {CORPUS_SIZE:,} scenes"
    if n_there < n_listed:
        said += f" ({n_listed - n_there:,} that its manifest lists are missing)"
    elif (dataset.folder / JOURNAL).exists():
        said += " (its build is under way, or was stopped)"
    return f"{said}; aeroscene dataset build makes the others"


def read_entries(folder: Path) -> tuple[SceneEntry, ...]:
    """Entries of a folder by its manifest and its journal, in the order of the numbers.

    Raises:
        DatasetError: If the manifest cannot be read.
    """
    entries = {entry.index: entry for entry in _read_manifest(folder)}
    # The journal is newer: a rebuild may have replaced scenes that the manifest lists.
    entries |= {entry.index: entry for entry in _read_journal(folder)}
    return tuple(entries[index] for index in sorted(entries))


def _read_manifest(folder: Path) -> tuple[SceneEntry, ...]:
    path = folder / MANIFEST
    try:
        manifest = msgspec.json.decode(read_bounded(path, _MOST_BYTES), type=_Manifest)
    except FileNotFoundError:
        return ()
    except NotADirectoryError:
        raise DatasetError(f"folder {str(folder)!r} is a file; valid: a folder") from None
    except OSError as error:
        reason = (error.strerror or type(error).__name__).lower()
        raise DatasetError(f"manifest {str(path)!r} cannot be read ({reason})") from None
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError, UnpackError) as error:
        raise DatasetError(
            f"manifest {str(path)!r} is damaged ({error}); valid: as it was made; "
            "delete it, and aeroscene dataset build makes it again"
        ) from None
    if (manifest.format, manifest.version) != (FORMAT, VERSION):
        raise DatasetError(
            f"manifest {str(path)!r}: format is {manifest.format!r} version {manifest.version}; "
            f"valid: {FORMAT!r} version {VERSION}"
        )
    return manifest.scenes


def _read_journal(folder: Path) -> Iterator[SceneEntry]:
    try:
        lines = (folder / JOURNAL).read_bytes().splitlines()
    except OSError:
        return
    for line in lines:
        # The last line of a build that was killed may be cut short: that scene is made again.
        with suppress(msgspec.DecodeError, UnicodeDecodeError):
            yield msgspec.json.decode(line, type=SceneEntry)


def journal_line(entry: SceneEntry) -> bytes:
    """Line of the journal for a scene that is finished; the line's end tells that it is whole."""
    return msgspec.json.encode(entry) + b"\n"


def write_manifest(folder: Path, entries: Iterable[SceneEntry]) -> None:
    """Write the manifest whole or not at all, one scene a line; equal entries give equal bytes.

    Args:
        folder: Folder of the dataset.
        entries: Entries of all its scenes, in any order.
    """
    lines = (msgspec.json.encode(e) for e in sorted(entries, key=lambda entry: entry.index))
    head = f'{{"format":"{FORMAT}","version":{VERSION},"scenes":[\n'.encode()
    with replacing(folder / MANIFEST) as file:
        file.write(head + b",\n".join(lines) + b"\n]}\n")


def make_scene(folder: Path, index: int) -> SceneEntry:
    """Curate one scene and write its file; the same bytes on every call.

    Args:
        folder: Folder of the dataset.
        index: Number of the scene, which is its seed.

    Raises:
        OSError: If the file cannot be written.
    """
    from aeroscene.corpus.curation import curate_scene

    try:
        scene = curate_scene(index)
    # A note keeps the type of the error, and tells which of a thousand scenes it was.
    except Exception as error:
        error.add_note(f"while curating scene {index}")
        raise
    return store_scene(folder, scene)


def store_scene(
    folder: Path,
    scene: Scene,
    index: int | None = None,
    sources: str | None = None,
    attempt: int = 0,
) -> SceneEntry:
    """Write a scene's file.

    Args:
        folder: Folder of the dataset.
        scene: The scene.
        index: Its number in the dataset; None for a scene of the corpus, whose number is its seed.
        sources: Digest of its origin; None for the curation code that runs now.
        attempt: Number of draws before this one that were rejected.

    Returns:
        Entry for the manifest.
    """
    file = f"{SCENES}/{scene.scene_id}.json.gz"
    # The file first: an entry without its file would describe a scene that does not exist.
    write_scene(scene, folder / file)
    return SceneEntry(
        **msgspec.structs.asdict(summarise(scene, scene.seed if index is None else index)),
        file=file,
        sha256=_sha256(folder / file),
        sources=curation_digest() if sources is None else sources,
        attempt=attempt,
    )


def is_whole(folder: Path, entry: SceneEntry) -> bool:
    """Return true if a scene's file is there, byte for byte; a file that cannot be read is not."""
    try:
        return _sha256(folder / entry.file) == entry.sha256
    except OSError:
        return False


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
