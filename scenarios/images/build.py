"""Builds a set of labelled images in a folder, and continues a build that was stopped.

    DIR/manifest.json           the request and all shards, with checksums
    DIR/journal.jsonl           only while a build is under way, or after it was killed
    DIR/shards/                 tar files in the naming of WebDataset
    DIR/coco/annotations.json   written at the end
    DIR/coco/images/            JPEG files

Each finished shard is written to the journal at once. Nothing in the folder depends on when, in
which order or by how many processes it was made.
"""

from __future__ import annotations

import fcntl
import hashlib
import re
import shutil
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO

import msgspec

from aeroscene.files import UnpackError, read_bounded, replacing
from aeroscene.processes import run_all
from scenarios.images.coco import COCO, write_coco
from scenarios.images.request import ImagesError, ImagesRequest, Shard
from scenarios.images.shard import (
    IMAGES,
    SHARDS,
    ShardEntry,
    frame_key,
    images_digest,
    images_name,
    make_shard,
)

FORMAT, VERSION = "aeroscene-images", 1
MANIFEST, JOURNAL = "manifest.json", "journal.jsonl"
_MOST_BYTES = 512 << 20


class Manifest(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Content of a folder of labelled images."""

    format: str
    version: int
    request: dict[str, Any]
    shards: tuple[ShardEntry, ...] = ()


@dataclass(frozen=True, kw_only=True, slots=True)
class ImagesPlan:
    """Work that is left in a folder."""

    folder: Path
    request: ImagesRequest
    kept: tuple[ShardEntry, ...]
    """Shards that are there."""
    to_make: tuple[Shard, ...]
    n_outdated: int
    """Number of shards that are there, but were made by other code."""

    @property
    def n_frames(self) -> int:
        """Number of frames to make."""
        return sum(shard.n_frames for shard in self.to_make)


def plan_images(folder: Path, request: ImagesRequest) -> ImagesPlan:
    """Plan a set of images in a folder.

    Args:
        folder: Folder of the set, existing or not.
        request: The set.

    Raises:
        ImagesError: If the folder holds another set, or its manifest is damaged.
    """
    present = read_manifest(folder)
    ours = {JOURNAL, SHARDS, Path(COCO).parent.name}
    if present is None and folder.is_dir() and {path.name for path in folder.iterdir()} - ours:
        raise ImagesError(f"out {str(folder)!r} holds other files; valid: a folder that is new")
    if present is not None:
        _require_same(folder, present.request, request.to_plain())
    entries = {e.shard: e for e in (present.shards if present else ()) if _is_whole(folder, e)}
    shards = tuple(request.shards())
    is_kept = {number: entry.sources == images_digest() for number, entry in entries.items()}
    return ImagesPlan(
        folder=folder,
        request=request,
        kept=tuple(entry for number, entry in sorted(entries.items()) if is_kept[number]),
        to_make=tuple(shard for shard in shards if not is_kept.get(shard.number, False)),
        n_outdated=sum(not kept for kept in is_kept.values()),
    )


def build_images(plan: ImagesPlan, jobs: int, on_frames: Callable[[int], None]) -> Manifest:
    """Execute a plan; however it ends, the folder holds whole shards only.

    Args:
        plan: Plan from `plan_images`.
        jobs: Number of processes.
        on_frames: Called with the number of frames of each finished shard.

    Returns:
        The manifest.

    Raises:
        ImagesError: If another build is running in the folder, or a scene cannot be shown.
        SceneError: If a scene cannot be opened.
        OSError: If a file cannot be written.
        WorkerDiedError: If a process was killed.
    """
    folder = plan.folder
    for name in (SHARDS, IMAGES):
        (folder / name).mkdir(parents=True, exist_ok=True)
    entries = list(plan.kept)
    with _journal(folder) as journal:
        # The request first: a build that is killed leaves a folder that says what it holds.
        _write_manifest(folder, plan.request, entries)
        if plan.to_make:
            # It would list images that are made again.
            (folder / COCO).unlink(missing_ok=True)
        try:
            make = partial(make_shard, folder, plan.request)
            with closing(run_all(make, plan.to_make, jobs)) as made:
                for entry in made:
                    journal.write(msgspec.json.encode(entry) + b"\n")
                    journal.flush()
                    entries.append(entry)
                    on_frames(entry.n_frames)
        finally:
            _remove_unlisted(folder, entries)
            manifest = _write_manifest(folder, plan.request, entries)
            (folder / JOURNAL).unlink()
    if not (folder / COCO).exists():
        write_coco(folder, manifest.shards)
    return manifest


def read_manifest(folder: Path) -> Manifest | None:
    """Return what a folder holds by its manifest and journal; None without a manifest.

    Raises:
        ImagesError: If the manifest is damaged, or of another format.
    """
    path = folder / MANIFEST
    try:
        manifest = msgspec.json.decode(read_bounded(path, _MOST_BYTES), type=Manifest)
    except FileNotFoundError:
        return None
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError, UnpackError) as error:
        raise ImagesError(
            f"manifest {str(path)!r} is damaged ({error}); valid: as it was made"
        ) from None
    if (manifest.format, manifest.version) != (FORMAT, VERSION):
        raise ImagesError(
            f"manifest {str(path)!r}: format is {manifest.format!r} version {manifest.version}; "
            f"valid: {FORMAT!r} version {VERSION}"
        )
    entries = {entry.shard: entry for entry in manifest.shards}
    # The journal is newer.
    entries |= {entry.shard: entry for entry in _read_journal(folder)}
    shards = tuple(entries[number] for number in sorted(entries))
    return msgspec.structs.replace(manifest, shards=shards)


def _read_journal(folder: Path) -> Iterator[ShardEntry]:
    try:
        lines = (folder / JOURNAL).read_bytes().splitlines()
    except OSError:
        return
    for line in lines:
        # The last line of a build that was killed may be cut short: that shard is made again.
        with suppress(msgspec.DecodeError, UnicodeDecodeError):
            yield msgspec.json.decode(line, type=ShardEntry)


def _require_same(folder: Path, present: dict[str, Any], wanted: dict[str, Any]) -> None:
    """Refuse to mix two sets in one folder."""
    for name, value in wanted.items():
        if present.get(name) != value:
            there, asked = (_short(each) for each in (present.get(name), value))
            raise ImagesError(
                f"out {str(folder)!r} holds images with {name} {there}, not {asked}; "
                "valid: the same options, or another folder"
            )


def _short(value: object) -> str:
    text = msgspec.json.encode(value).decode()
    return text if len(text) <= 60 else f"{text[:57]}..."


def _is_whole(folder: Path, entry: ShardEntry) -> bool:
    """Return whether a shard's files are there, the tar file byte for byte."""
    images = folder / images_name(entry.shard)
    frames = range(entry.first_frame, entry.first_frame + entry.n_frames)
    if not all((images / f"{frame_key(frame)}.jpg").is_file() for frame in frames):
        return False
    try:
        with (folder / entry.file).open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest() == entry.sha256
    except OSError:
        return False


def _write_manifest(
    folder: Path, request: ImagesRequest, entries: Sequence[ShardEntry]
) -> Manifest:
    manifest = Manifest(
        format=FORMAT,
        version=VERSION,
        request=request.to_plain(),
        shards=tuple(sorted(entries, key=lambda entry: entry.shard)),
    )
    with replacing(folder / MANIFEST) as file:
        file.write(msgspec.json.format(msgspec.json.encode(manifest), indent=1) + b"\n")
    return manifest


@contextmanager
def _journal(folder: Path) -> Iterator[BinaryIO]:
    """Open the journal for appending, with an exclusive lock."""
    with (folder / JOURNAL).open("ab") as journal:
        try:
            # The system releases the lock of a killed process.
            fcntl.flock(journal, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise ImagesError(
                f"out {str(folder)!r} is being built by another process; "
                "valid: wait for its end, or another folder"
            ) from None
        # The last line of a killed build may be incomplete; a line break ends it.
        journal.write(b"\n" if journal.tell() else b"")
        yield journal


def _remove_unlisted(folder: Path, entries: Sequence[ShardEntry]) -> None:
    """Remove the files of shards that were not finished, or whose process was not heard out."""
    listed = {entry.shard for entry in entries}
    # Names of ours, finished and unfinished; files of others stay.
    for path in (folder / SHARDS).iterdir():
        match = re.fullmatch(r"(\.)?images-(\d{6})\.tar(\..*)?", path.name)
        if match and (match[1] or int(match[2]) not in listed):
            path.unlink(missing_ok=True)
    for path in (folder / IMAGES).iterdir():
        match = re.fullmatch(r"(\.)?(\d{6})(\..*)?", path.name)
        if match and (match[1] or int(match[2]) not in listed):
            shutil.rmtree(path, ignore_errors=True)
