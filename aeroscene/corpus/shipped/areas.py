"""Interaction areas of several scenes as columns, each told from the object that bears it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import get_args

import numpy as np
from jaxtyping import Int64

from aeroscene.corpus.shipped.columns import ColumnReader, ColumnWriter
from aeroscene.corpus.shipped.decimals import Decimals, join_doubles, split_doubles
from aeroscene.corpus.shipped.objects import (
    LENGTH_DIGITS,
    NO_ROW,
    Column,
    ObjectColumns,
    Vectors,
    join_vectors,
    of_rows,
    rows_of,
    split_vectors,
)
from aeroscene.corpus.shipped.polygons import read_vertices, write_vertices
from aeroscene.scene import AreaKind, DroneClass, InteractionArea, Scene

_ANGLE_DIGITS = 6
_KINDS: tuple[AreaKind, ...] = get_args(AreaKind)
_CLASSES: tuple[DroneClass, ...] = get_args(DroneClass)


@dataclass(frozen=True, slots=True, kw_only=True)
class AreaColumns:
    """Areas of several scenes, a row each, scene after scene."""

    counts: Int64[np.ndarray, " scenes"]
    """Areas of each scene."""
    ids: Column
    bearers: Column
    """Row of the object, `NO_ROW` for the bare ground."""
    kinds: Column
    classes: Column
    surfaces: Column
    """Place in the palette."""
    palette: list[str]
    centroids: Vectors
    radii: Decimals
    clearances: Decimals
    slopes: Decimals
    sides: Column
    """Vertices of each border."""
    vertices: Vectors
    """Vertices of all borders, one after another."""


def gather_areas(scenes: Sequence[Scene]) -> AreaColumns:
    """The areas of scenes in columns."""
    areas = [area for scene in scenes for area in scene.interaction_areas]
    palette = list(dict.fromkeys(area.surface for area in areas))
    surface = {name: number for number, name in enumerate(palette)}
    return AreaColumns(
        counts=np.array([len(scene.interaction_areas) for scene in scenes], np.int64),
        ids=np.array([area.id for area in areas], np.int64),
        bearers=_bearer_rows(scenes),
        kinds=np.array([_KINDS.index(area.kind) for area in areas], np.int64),
        classes=np.array([_CLASSES.index(area.drone_class) for area in areas], np.int64),
        surfaces=np.array([surface[area.surface] for area in areas], np.int64),
        palette=palette,
        centroids=split_vectors([area.centroid for area in areas]),
        radii=_split([area.radius for area in areas], LENGTH_DIGITS),
        clearances=_split([area.clearance_m for area in areas], LENGTH_DIGITS),
        slopes=_split([area.slope_rad for area in areas], _ANGLE_DIGITS),
        sides=np.array([len(area.polygon) for area in areas], np.int64),
        vertices=split_vectors([vertex for area in areas for vertex in area.polygon]),
    )


def _split(values: Sequence[float], digits: int) -> Decimals:
    return split_doubles(np.array(values, np.float64), digits)


def _bearer_rows(scenes: Sequence[Scene]) -> Column:
    rows: list[int] = []
    start = 0
    for scene in scenes:
        row = {obj.id: start + index for index, obj in enumerate(scene.objects)}
        ids = [area.object_id for area in scene.interaction_areas]
        rows += [NO_ROW if object_id is None else row[object_id] for object_id in ids]
        start += len(scene.objects)
    return np.array(rows, np.int64)


def write_areas(
    areas: AreaColumns, objects: ObjectColumns, ceilings: Column, writer: ColumnWriter
) -> None:
    """Append the columns.

    Args:
        areas: The areas.
        objects: The objects of the same scenes.
        ceilings: Top of the flight volume of each scene, in 0.1 mm.
        writer: Takes the columns.
    """
    writer.add(areas.counts)
    writer.add(np.diff(areas.ids, prepend=NO_ROW))
    writer.add(np.diff(areas.bearers, prepend=NO_ROW))
    writer.add_plain(areas.palette)
    for column in (areas.kinds, areas.classes, areas.surfaces, areas.sides):
        writer.add(column)
    writer.add_decimals(areas.radii)
    writer.add_decimals(areas.slopes)
    bearing = _middles_of_tops(areas.bearers, objects)
    for column, guess in zip(areas.centroids, bearing, strict=True):
        writer.add_decimals(Decimals(column.units - guess, column.steps))
    free = np.repeat(ceilings, areas.counts) - areas.centroids[2].units
    writer.add_decimals(Decimals(areas.clearances.units - free, areas.clearances.steps))
    _write_borders(areas, writer)


def read_areas(reader: ColumnReader, objects: ObjectColumns, ceilings: Column) -> AreaColumns:
    """The columns that were appended; arguments as for `write_areas`."""
    counts = reader.take()
    ids, bearers = (np.cumsum(reader.take()) + NO_ROW for _ in range(2))
    palette = reader.take_plain(list[str])
    kinds, classes, surfaces, sides = (reader.take() for _ in range(4))
    radii, slopes = (reader.take_decimals() for _ in range(2))
    bearing = _middles_of_tops(bearers, objects)
    told = (reader.take_decimals() for _ in range(3))
    x, y, z = (
        Decimals(column.units + guess, column.steps)
        for column, guess in zip(told, bearing, strict=True)
    )
    below = reader.take_decimals()
    free = np.repeat(ceilings, counts) - z.units
    return AreaColumns(
        counts=counts,
        ids=ids,
        bearers=bearers,
        kinds=kinds,
        classes=classes,
        surfaces=surfaces,
        palette=palette,
        centroids=(x, y, z),
        radii=radii,
        clearances=Decimals(below.units + free, below.steps),
        slopes=slopes,
        sides=sides,
        vertices=_read_borders(sides, (x, y, z), radii, reader),
    )


def _middles_of_tops(bearers: Column, objects: ObjectColumns) -> tuple[Column, Column, Column]:
    """Middle of the upper face of each bearer, the origin for the bare ground; in 0.1 mm."""
    x, y, _ = objects.places
    return of_rows(x.units, bearers), of_rows(y.units, bearers), of_rows(objects.tops(), bearers)


def _write_borders(areas: AreaColumns, writer: ColumnWriter) -> None:
    centroids = np.stack([axis.units for axis in areas.centroids], axis=1)
    vertices = np.stack([axis.units for axis in areas.vertices], axis=1)
    for sides in np.unique(areas.sides).tolist():
        which, rows = _of_sides(areas.sides, sides)
        from_centroid = vertices[rows] - centroids[which, None]
        write_vertices(from_centroid, areas.radii.units[which], writer)
    for axis in areas.vertices:
        writer.add(axis.steps)


def _read_borders(
    n_sides: Column, centroids: Vectors, radii: Decimals, reader: ColumnReader
) -> Vectors:
    middles = np.stack([axis.units for axis in centroids], axis=1)
    vertices = np.zeros((int(n_sides.sum()), 3), np.int64)
    for sides in np.unique(n_sides).tolist():
        which, rows = _of_sides(n_sides, sides)
        vertices[rows] = read_vertices(sides, radii.units[which], reader) + middles[which, None]
    x, y, z = (Decimals(units, reader.take()) for units in vertices.T)
    return x, y, z


def _of_sides(n_sides: Column, sides: int) -> tuple[Column, Int64[np.ndarray, "m sides"]]:
    """Areas with that many vertices, and the rows of these among all vertices."""
    which = np.flatnonzero(n_sides == sides)
    starts = np.cumsum(n_sides) - n_sides
    return which, starts[which, None] + np.arange(sides)


def build_areas(
    areas: AreaColumns, objects: ObjectColumns, number: int
) -> tuple[InteractionArea, ...]:
    """The areas of one of the scenes."""
    rows = rows_of(areas.counts, number)
    ends = np.cumsum(areas.sides[rows]).tolist()
    first = int(areas.sides[: rows.start].sum())
    vertices = join_vectors(areas.vertices, slice(first, first + (ends or [0])[-1]))
    polygons = [tuple(vertices[a:b]) for a, b in zip([0, *ends], ends, strict=False)]
    centroids = join_vectors(areas.centroids, rows)
    lengths = (areas.radii, areas.clearances)
    radii, clearances = (_join(column, rows, LENGTH_DIGITS) for column in lengths)
    slopes = _join(areas.slopes, rows, _ANGLE_DIGITS)
    named = (areas.ids, areas.bearers, areas.kinds, areas.classes, areas.surfaces)
    ids, bearers, kinds, classes, surfaces = (column[rows].tolist() for column in named)
    return tuple(
        InteractionArea(
            id=ids[i],
            kind=_KINDS[kinds[i]],
            object_id=None if bearers[i] == NO_ROW else int(objects.ids[bearers[i]]),
            polygon=polygons[i],
            centroid=centroids[i],
            radius=radii[i],
            drone_class=_CLASSES[classes[i]],
            slope_rad=slopes[i],
            clearance_m=clearances[i],
            surface=areas.palette[surfaces[i]],
        )
        for i in range(len(ids))
    )


def _join(column: Decimals, rows: slice, digits: int) -> list[float]:
    return join_doubles(Decimals(column.units[rows], column.steps[rows]), digits).tolist()
