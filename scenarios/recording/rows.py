"""Rows of a recording by entity and component, as arrays, through rerun's own reader."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from jaxtyping import Float, Int

from scenarios.recording import layout
from scenarios.recording.summary import PROPERTIES, chunks, first_row

Row = Any
"""One row of one component, as rerun has it: a list of instances."""


class RecordedRows:
    """Rows of some entities of a recording.

    Attributes:
        properties: Properties of the recording, by name.
        entities: Entities that were found, without their leading slash.
        others: Entities that change in time, and were not wanted.
    """

    def __init__(self, path: Path, wanted: Iterable[str]) -> None:
        """Read the rows.

        Args:
            path: A file that rerun can read; see `summary.readable`.
            wanted: Entities, or beginnings of their paths.
        """
        prefixes = tuple(f"/{entity}" for entity in wanted)
        self.properties: dict[str, dict[str, Any]] = {}
        self.others: set[str] = set()
        self._batches: dict[str, list[pa.RecordBatch]] = defaultdict(list)
        for chunk in chunks(path):
            if chunk.entity_path.startswith(PROPERTIES):
                self.properties[chunk.entity_path.removeprefix(PROPERTIES)] = first_row(chunk)
            elif chunk.entity_path.startswith(prefixes):
                self._batches[chunk.entity_path[1:]].append(chunk.to_record_batch())
            elif not chunk.is_static:
                self.others.add(chunk.entity_path[1:])

    @property
    def entities(self) -> list[str]:
        """Entities that were found, in order of their names."""
        return sorted(self._batches)

    def vectors(
        self, entity: str, component: str, width: int = 3
    ) -> tuple[Int[np.ndarray, " n"], Float[np.ndarray, "n w"]]:
        """Times, us, and rows of `width` numbers each, in order of time."""
        times, parts = [np.zeros(0, dtype=np.int64)], [np.zeros((0, width))]
        for batch in self._with(entity, component):
            column = batch.column(component)
            while not pa.types.is_floating(column.type):
                column = column.flatten()
            times.append(_times_us(batch))
            parts.append(column.to_numpy(zero_copy_only=False).reshape(-1, width))
        time_us = np.concatenate(times)
        order = np.argsort(time_us, kind="stable")
        return time_us[order], np.concatenate(parts)[order]

    def width(self, entity: str, component: str) -> int:
        """Numbers in a row of an entity; 0 if it has none."""
        for batch in self._with(entity, component):
            return max((len(row.as_py() or ()) for row in batch.column(component)), default=0)
        return 0

    def rows(self, entity: str, component: str) -> list[tuple[int, Row]]:
        """Time, us, and value of each row, in order of time; time 0 where it never changes."""
        found: list[tuple[int, Row]] = []
        for batch in self._with(entity, component):
            has_time = layout.TIMELINE in batch.schema.names
            times = _times_us(batch).tolist() if has_time else [0] * batch.num_rows
            values = batch.column(component).to_pylist()
            found += [(t, row) for t, row in zip(times, values, strict=True) if row is not None]
        return sorted(found, key=lambda item: item[0])

    def blobs(self, entity: str, component: str) -> Iterator[tuple[int, bytes]]:
        """Time, us, and bytes of each row, such as an encoded image."""
        for batch in self._with(entity, component):
            rows = batch.column(component)
            for time_us, row in zip(_times_us(batch).tolist(), rows, strict=True):
                if row.is_valid:
                    yield time_us, row.values[0].values.to_numpy(zero_copy_only=False).tobytes()

    def clouds(self, entity: str, component: str) -> Iterator[tuple[int, Float[np.ndarray, "k 3"]]]:
        """Time, us, and points of each row."""
        for batch in self._with(entity, component):
            rows = batch.column(component)
            for time_us, row in zip(_times_us(batch).tolist(), rows, strict=True):
                if row.is_valid:
                    flat = row.values.flatten().to_numpy(zero_copy_only=False)
                    yield time_us, flat.reshape(-1, 3)

    def _with(self, entity: str, component: str) -> list[pa.RecordBatch]:
        return [b for b in self._batches.get(entity, []) if component in b.schema.names]


def _times_us(batch: pa.RecordBatch) -> Int[np.ndarray, " n"]:
    return batch.column(layout.TIMELINE).cast(pa.int64()).to_numpy() // 1000
