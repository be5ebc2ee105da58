"""Objects of several scenes as columns, each number told by how it differs from what is likely.

Places are told from the parent's, undersides from the parent's top, and what depends on the
category is sorted by it, so that like stands beside like. Lengths count in 0.1 mm, quaternions in
1e-9; what is no such multiple keeps its last bits all the same (`decimals`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import get_args

import numpy as np
from jaxtyping import Float64, Int64

from aeroscene.corpus.shipped.attributes import Attributes, read_attributes, write_attributes
from aeroscene.corpus.shipped.columns import ColumnReader, ColumnWriter
from aeroscene.corpus.shipped.decimals import Decimals, join_doubles, split_doubles
from aeroscene.scene import ObjectDomain, OrientedBox, Scene, SceneObject, Vector3

LENGTH_DIGITS = 4
QUATERNION_DIGITS = 9
NO_ROW = -1
_DOMAINS: tuple[ObjectDomain, ...] = get_args(ObjectDomain)

Column = Int64[np.ndarray, " n"]
Vectors = tuple[Decimals, Decimals, Decimals]
"""Axis by axis."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ObjectColumns:
    """Objects of several scenes, a row each, scene after scene."""

    counts: Int64[np.ndarray, " scenes"]
    """Objects of each scene."""
    ids: Column
    parents: Column
    """Row of the parent, `NO_ROW` for roots."""
    categories: Column
    domains: Column
    places: Vectors
    sizes: Vectors
    turns: Column
    """Row of the quaternion."""
    quaternions: Float64[np.ndarray, "m 4"]
    attributes: Sequence[Attributes]

    def tops(self) -> Column:
        """Height of the upper face of each box, in 0.1 mm; as if all were upright."""
        return self.places[2].units + self.sizes[2].units // 2

    def starts(self) -> Column:
        """Row of the first object of each row's scene."""
        return np.repeat(np.cumsum(self.counts) - self.counts, self.counts)

    def by_category(self) -> Column:
        """Rows so that those of one category stand together."""
        return np.argsort(self.categories, kind="stable")


def gather_objects(scenes: Sequence[Scene]) -> ObjectColumns:
    """The objects of scenes in columns."""
    objects = [obj for scene in scenes for obj in scene.objects]
    quaternions = np.array([obj.bbox.q for obj in objects], np.float64).reshape(-1, 4)
    # As bits: minus zero is another number than zero here.
    distinct, turns = np.unique(quaternions.view(np.int64), axis=0, return_inverse=True)
    return ObjectColumns(
        counts=np.array([len(scene.objects) for scene in scenes], np.int64),
        ids=np.array([obj.id for obj in objects], np.int64),
        parents=_parent_rows(scenes),
        categories=np.array([obj.category_id for obj in objects], np.int64),
        domains=np.array([_DOMAINS.index(obj.domain) for obj in objects], np.int64),
        places=split_vectors([obj.bbox.p for obj in objects]),
        sizes=split_vectors([obj.bbox.s for obj in objects]),
        turns=turns.reshape(-1).astype(np.int64),
        quaternions=distinct.view(np.float64),
        attributes=[dict(obj.attributes) for obj in objects],
    )


def split_vectors(vectors: Sequence[Vector3]) -> Vectors:
    """Lengths, m, as decimals, axis by axis."""
    columns = np.array(vectors, np.float64).reshape(-1, 3).T
    x, y, z = (split_doubles(column, LENGTH_DIGITS) for column in columns)
    return x, y, z


def _parent_rows(scenes: Sequence[Scene]) -> Column:
    rows: list[int] = []
    for scene in scenes:
        row = {obj.id: len(rows) + index for index, obj in enumerate(scene.objects)}
        rows += [NO_ROW if obj.parent_id is None else row[obj.parent_id] for obj in scene.objects]
    return np.array(rows, np.int64)


def write_objects(objects: ObjectColumns, writer: ColumnWriter) -> None:
    """Append the columns."""
    parents, order = objects.parents, objects.by_category()
    (x, y, z), sizes = objects.places, objects.sizes
    writer.add(objects.counts)
    writer.add(np.diff(objects.ids, prepend=NO_ROW))
    writer.add(np.diff(_within_scenes(parents, -objects.starts()), prepend=NO_ROW))
    writer.add(objects.categories)
    for size in sizes:
        writer.add_decimals(Decimals(*(column[order] for column in size)))
    writer.add_decimals(Decimals(_from_parents(x.units, parents), x.steps))
    writer.add_decimals(Decimals(_from_parents(y.units, parents), y.steps))
    foot = z.units - sizes[2].units // 2
    on_top = _from_parents(foot, parents) - of_rows(_rise(sizes[2]), parents)
    writer.add_decimals(Decimals(on_top, z.steps))
    writer.add(objects.turns)
    for column in objects.quaternions.T:
        writer.add_decimals(split_doubles(column, QUATERNION_DIGITS))
    writer.add(objects.domains[order])
    write_attributes([objects.attributes[row] for row in order.tolist()], writer)


def read_objects(reader: ColumnReader) -> ObjectColumns:
    """The columns that were appended."""
    counts = reader.take()
    ids = np.cumsum(reader.take()) + NO_ROW
    starts = np.repeat(np.cumsum(counts) - counts, counts)
    parents = _within_scenes(np.cumsum(reader.take()) + NO_ROW, starts)
    categories = reader.take()
    back = np.argsort(np.argsort(categories, kind="stable"), kind="stable")
    length, width, height = (
        Decimals(*(column[back] for column in reader.take_decimals())) for _ in range(3)
    )
    x, y, on_top = (reader.take_decimals() for _ in range(3))
    foot = _from_origin(on_top.units + of_rows(_rise(height), parents), parents)
    turns = reader.take()
    quaternions = [join_doubles(reader.take_decimals(), QUATERNION_DIGITS) for _ in range(4)]
    domains = reader.take()[back]
    attributes = read_attributes(reader)
    return ObjectColumns(
        counts=counts,
        ids=ids,
        parents=parents,
        categories=categories,
        domains=domains,
        places=(
            Decimals(_from_origin(x.units, parents), x.steps),
            Decimals(_from_origin(y.units, parents), y.steps),
            Decimals(foot + height.units // 2, on_top.steps),
        ),
        sizes=(length, width, height),
        turns=turns,
        quaternions=np.stack(quaternions, axis=1),
        attributes=[attributes[row] for row in back.tolist()],
    )


def _within_scenes(parents: Column, shift: Column) -> Column:
    return np.where(parents == NO_ROW, NO_ROW, parents + shift)


def _rise(height: Decimals) -> Column:
    """Height from the underside to the top, as `ObjectColumns.tops` has it."""
    return 2 * (height.units // 2)


def of_rows(values: Column, rows: Column) -> Column:
    """Values in some rows; 0 where the row is `NO_ROW`."""
    # NO_ROW counts from the end.
    return np.append(values, 0)[rows]


def rows_of(counts: Column, number: int) -> slice:
    """Rows that belong to one scene of several."""
    end = int(counts[: number + 1].sum())
    return slice(end - int(counts[number]), end)


def _from_parents(values: Column, parents: Column) -> Column:
    return values - of_rows(values, parents)


def _from_origin(differences: Column, parents: Column) -> Column:
    """Sums of differences from the root down to each row: undoes `_from_parents`."""
    totals, ancestors = differences, parents
    while np.any(ancestors != NO_ROW):
        totals = totals + of_rows(totals, ancestors)
        ancestors = np.append(ancestors, NO_ROW)[ancestors]
    return totals


def build_objects(objects: ObjectColumns, number: int, scene_id: str) -> tuple[SceneObject, ...]:
    """The objects of one of the scenes."""
    rows = rows_of(objects.counts, number)
    places = join_vectors(objects.places, rows)
    sizes = join_vectors(objects.sizes, rows)
    quaternions = objects.quaternions[objects.turns[rows]].tolist()
    ids = objects.ids[rows].tolist()
    parents = [
        None if row == NO_ROW else ids[row - rows.start] for row in objects.parents[rows].tolist()
    ]
    categories, domains = objects.categories[rows].tolist(), objects.domains[rows].tolist()
    return tuple(
        SceneObject(
            id=ids[i],
            scene_id=scene_id,
            parent_id=parents[i],
            category_id=categories[i],
            bbox=OrientedBox(places[i], tuple(quaternions[i]), sizes[i]),
            domain=_DOMAINS[domains[i]],
            attributes=attributes,
        )
        for i, attributes in enumerate(objects.attributes[rows])
    )


def join_vectors(axes: Vectors, rows: slice) -> list[Vector3]:
    """The vectors of some rows, m."""
    columns = (
        join_doubles(Decimals(units[rows], steps[rows]), LENGTH_DIGITS) for units, steps in axes
    )
    return list(zip(*(column.tolist() for column in columns), strict=True))
