"""Writes trials into the folder of a dataset, each whole or not at all.

Each table has a folder, with a Parquet file for each trial. The images and scans of a trial are one
tar file in the naming of WebDataset. The tables of frames and scans hold the place of each file in
the tar, so that one read gets it. The file in `trials/` is written last: if it is there, the trial
is complete.
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
from scenarios.trial_data.reading.frames import IMAGES
from scenarios.trial_data.tables import SCHEMA_FILE, TABLES, Column, arrow_schema, schema_json

SHARDS = "images"
COMMITTED = "trials"
_IN_SHARD: Mapping[str, tuple[str, ...]] = {"frames": tuple(IMAGES), "scans": ("points",)}
"""Kinds of files that the rows of a table have in the shard."""
DATASET_TABLES: Mapping[str, tuple[Column, ...]] = {
    name: (
        *columns,
        *(
            Column(f"{kind}_{what}", pa.int64(), f"{says} of it in {SHARDS}/TRIAL.tar; null: none")
            for kind in _IN_SHARD.get(name, ())
            for what, says in (("offset", "first byte"), ("bytes", "length in bytes"))
        ),
    )
    for name, columns in TABLES.items()
}
"""Columns of each table of a dataset."""


class _Place(NamedTuple):
    """Place of a file in a tar."""

    offset: int
    n_bytes: int


def has_trial(folder: Path, name: str) -> bool:
    """Return whether a trial is in a dataset, complete."""
    return (folder / COMMITTED / f"{name}.parquet").is_file()


def add_trial(folder: Path, trial: RecordedTrial) -> None:
    """Add a trial to a dataset, which is created if it is missing.

    Raises:
        OSError: If it cannot be written; nothing of the trial is left.
    """
    written = [folder / SHARDS / f"{trial.name}.tar"]
    # Reversed, so that `trials`, the first of the tables, is written last.
    written += [folder / name / f"{trial.name}.parquet" for name in reversed(tuple(TABLES))]
    try:
        for path in written:
            path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(folder / SCHEMA_FILE) as file:
            file.write(schema_json(DATASET_TABLES))
        places = _write_shard(written[0], trial)
        for path in written[1:]:
            table = trial.tables[path.parent.name]
            if path.parent.name in _IN_SHARD:
                table = _with_places(table, path.parent.name, places)
            with replacing(path) as file:
                pq.write_table(table, file, compression="zstd")
    # On any exception, Ctrl-C included.
    except BaseException:
        for path in written:
            path.unlink(missing_ok=True)
        raise


def _write_shard(path: Path, trial: RecordedTrial) -> dict[str, _Place]:
    """Write the images and scans of a trial, and each one's row of its table as JSON.

    The names up to the first dot are the keys of WebDataset's samples, so the trial's name may have
    none.
    """
    places: dict[str, _Place] = {}
    encoded = {each.file: each.data for each in (*trial.pictures, *trial.scans)}
    stem = trial.name.replace(".", "_")
    with replacing(path) as file, tarfile.open(fileobj=file, mode="w") as tar:
        for table, kinds in _IN_SHARD.items():
            for row in trial.tables[table].to_pylist():
                is_scan = table == "scans"
                which = "lidar" if is_scan else row["camera"]
                number = row["scan" if is_scan else "frame"]
                key = f"{stem}_{number:06d}_{which}"
                for kind in kinds:
                    if (name := row[f"{kind}_file"]) is not None:
                        suffix = name.partition(".")[2]
                        places[name] = _append(tar, file, f"{key}.{suffix}", encoded[name])
                _append(tar, file, f"{key}.json", json.dumps(row).encode())
    return places


def _append(tar: tarfile.TarFile, file: BinaryIO, name: str, data: bytes) -> _Place:
    member = tarfile.TarInfo(name)
    member.size = len(data)
    tar.addfile(member, io.BytesIO(data))
    # A tar file pads each member to whole blocks; the data begins that far before its end.
    padded = -(-member.size // tarfile.BLOCKSIZE) * tarfile.BLOCKSIZE
    return _Place(file.tell() - padded, member.size)


def _with_places(table: pa.Table, name: str, places: Mapping[str, _Place]) -> pa.Table:
    arrays = list(table.columns)
    for kind in _IN_SHARD[name]:
        files: Iterable[str | None] = table[f"{kind}_file"].to_pylist()
        found = [None if file is None else places[file] for file in files]
        arrays.append(pa.array([place and place.offset for place in found], pa.int64()))
        arrays.append(pa.array([place and place.n_bytes for place in found], pa.int64()))
    return pa.table(arrays, schema=arrow_schema(DATASET_TABLES[name]))
