"""Writes trials into the folder of a dataset, each whole or not at all.

A folder a table, a Parquet file a trial in it; the images of a trial are one tar file in the naming
of WebDataset. The table of frames says where in the tar each image is, so that one read gets it.
The file in `trials/` is written last: a trial of which it is there is complete.
"""

from __future__ import annotations

import io
import json
import tarfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import BinaryIO, NamedTuple

import pyarrow as pa
import pyarrow.parquet as pq

from aeroscene.files import replacing
from scenarios.trial_data.reading import RecordedTrial
from scenarios.trial_data.tables import SCHEMA_FILE, TABLES, Column, arrow_schema, schema_json

SHARDS = "images"
COMMITTED = "trials"
_PLACES = tuple(
    Column(f"{kind}_{what}", pa.int64(), f"{says} of the image in {SHARDS}/TRIAL.tar; null: none")
    for kind in ("rgb", "depth")
    for what, says in (("offset", "first byte"), ("bytes", "length in bytes"))
)
DATASET_TABLES: Mapping[str, tuple[Column, ...]] = {
    **TABLES,
    "frames": (*TABLES["frames"], *_PLACES),
}
"""Columns of each table of a dataset."""


class _Place(NamedTuple):
    """Place of a file in a tar."""

    offset: int
    n_bytes: int


def has_trial(folder: Path, name: str) -> bool:
    """Whether a trial is in a dataset, whole."""
    return (folder / COMMITTED / f"{name}.parquet").is_file()


def add_trial(folder: Path, trial: RecordedTrial) -> None:
    """Add a trial to a dataset, which is made where it is missing.

    Raises:
        OSError: If it cannot be written; nothing of the trial is left.
    """
    written = [folder / SHARDS / f"{trial.name}.tar"]
    written += [folder / name / f"{trial.name}.parquet" for name in reversed(tuple(TABLES))]
    try:
        for path in written:
            path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(folder / SCHEMA_FILE) as file:
            file.write(schema_json(DATASET_TABLES))
        places = _write_shard(written[0], trial)
        for path in written[1:]:
            table = trial.tables[path.parent.name]
            if path.parent.name == "frames":
                table = _with_places(table, places)
            with replacing(path) as file:
                pq.write_table(table, file, compression="zstd")
    except BaseException:
        for path in written:
            path.unlink(missing_ok=True)
        raise


def _write_shard(path: Path, trial: RecordedTrial) -> dict[str, _Place]:
    """Write the images of a trial, and each frame's row of its table as JSON.

    The names up to the first dot are the keys of WebDataset's samples.
    """
    places: dict[str, _Place] = {}
    encoded = {picture.file: picture.data for picture in trial.pictures}
    with replacing(path) as file, tarfile.open(fileobj=file, mode="w") as tar:
        for frame in trial.tables["frames"].to_pylist():
            key = f"{trial.name.replace('.', '_')}_{frame['frame']:06d}_{frame['camera']}"
            for kind in ("rgb", "depth"):
                if (name := frame[f"{kind}_file"]) is not None:
                    suffix = name.partition(".")[2]
                    places[name] = _append(tar, file, f"{key}.{suffix}", encoded[name])
            _append(tar, file, f"{key}.json", json.dumps(frame).encode())
    return places


def _append(tar: tarfile.TarFile, file: BinaryIO, name: str, data: bytes) -> _Place:
    member = tarfile.TarInfo(name)
    member.size = len(data)
    tar.addfile(member, io.BytesIO(data))
    padded = -(-member.size // tarfile.BLOCKSIZE) * tarfile.BLOCKSIZE
    return _Place(file.tell() - padded, member.size)


def _with_places(frames: pa.Table, places: Mapping[str, _Place]) -> pa.Table:
    columns: dict[str, list[int | None]] = {}
    for kind in ("rgb", "depth"):
        files: Iterable[str | None] = frames[f"{kind}_file"].to_pylist()
        found = [None if file is None else places[file] for file in files]
        columns[f"{kind}_offset"] = [place and place.offset for place in found]
        columns[f"{kind}_bytes"] = [place and place.n_bytes for place in found]
    arrays = [*frames.columns, *(pa.array(columns[c.name], c.type) for c in _PLACES)]
    return pa.table(arrays, schema=arrow_schema(DATASET_TABLES["frames"]))
