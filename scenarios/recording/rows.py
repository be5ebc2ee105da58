"""Rows of a recording by entity and component, as arrays, through rerun's own reader.

rerun stores a recording as chunks: Arrow tables of some rows of one entity. A reader wants all rows
of an entity as one array in order of time. `RecordedRows` reads the file once, keeps the chunks of
the wanted entities, and joins them on demand.
"""

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
"""One row of one component, in rerun's form: a list of instances."""


class RecordedRows:
    """Rows of some entities of a recording.

    Attributes:
        properties: Properties of the recording, by name.
        entities: Entities that were found, without their leading slash.
        others: Entities that change in time and were not wanted, for a report of what is left out.
    """

    def __init__(self, path: Path, wanted: Iterable[str]) -> None:
        """Read the rows.

        Args:
            path: A file that rerun can read; see `summary.readable`.
            wanted: Entities, or beginnings of their paths, without the leading slash.
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
        """Return the rows of an entity whose component is a vector of numbers.

        Args:
            entity: Path of the entity.
            component: Name of the component.
            width: Numbers in each row.

        Returns:
            Simulated times in us, and the rows, in order of time; empty if there are none.
        """
        times, parts = [np.zeros(0, dtype=np.int64)], [np.zeros((0, width))]
        for batch in self._with(entity, component):
            column = batch.column(component)
            # Lists of instances, which are themselves lists of fixed length.
            while not pa.types.is_floating(column.type):
                column = column.flatten()
            times.append(_times_us(batch))
            parts.append(column.to_numpy(zero_copy_only=False).reshape(-1, width))
        time_us = np.concatenate(times)
        # Chunks need not be in order of time, nor need their rows.
        order = np.argsort(time_us, kind="stable")
        return time_us[order], np.concatenate(parts)[order]

    def width(self, entity: str, component: str) -> int:
        """Return the most numbers in a row of an entity's first chunk; 0 if it has none."""
        for batch in self._with(entity, component):
            return max((len(row.as_py() or ()) for row in batch.column(component)), default=0)
        return 0

    def rows(self, entity: str, component: str) -> list[tuple[int, Row]]:
        """Return the rows of an entity whose component has any form.

        Args:
            entity: Path of the entity.
            component: Name of the component.

        Returns:
            Simulated time in us and value of each row, in order of time. The time is 0 for an
            entity that never changes.
        """
        found: list[tuple[int, Row]] = []
        for batch in self._with(entity, component):
            has_time = layout.TIMELINE in batch.schema.names
            times = _times_us(batch).tolist() if has_time else [0] * batch.num_rows
            values = batch.column(component).to_pylist()
            found += [(t, row) for t, row in zip(times, values, strict=True) if row is not None]
        return sorted(found, key=lambda item: item[0])

    def blobs(self, entity: str, component: str) -> Iterator[tuple[int, bytes]]:
        """Yield the rows of an entity whose component is a blob, such as an encoded image.

        Args:
            entity: Path of the entity.
            component: Name of the component.

        Yields:
            Simulated time in us and bytes, one image at a time, because copies of all need room.
        """
        for batch in self._with(entity, component):
            rows = batch.column(component)
            for time_us, row in zip(_times_us(batch).tolist(), rows, strict=True):
                if row.is_valid:
                    yield time_us, row.values[0].values.to_numpy(zero_copy_only=False).tobytes()

    def clouds(self, entity: str, component: str) -> Iterator[tuple[int, Float[np.ndarray, "k 3"]]]:
        """Yield the rows of an entity whose component is a cloud of points.

        Args:
            entity: Path of the entity.
            component: Name of the component.

        Yields:
            Simulated time in us and points, one row at a time.
        """
        for batch in self._with(entity, component):
            rows = batch.column(component)
            for time_us, row in zip(_times_us(batch).tolist(), rows, strict=True):
                if row.is_valid:
                    flat = row.values.flatten().to_numpy(zero_copy_only=False)
                    yield time_us, flat.reshape(-1, 3)

    def _with(self, entity: str, component: str) -> list[pa.RecordBatch]:
        return [b for b in self._batches.get(entity, []) if component in b.schema.names]


# rerun keeps durations in ns.
def _times_us(batch: pa.RecordBatch) -> Int[np.ndarray, " n"]:
    return batch.column(layout.TIMELINE).cast(pa.int64()).to_numpy() // 1000
