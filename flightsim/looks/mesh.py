"""Mesh of all surfaces of a world as arrays: lit, shadowed and merged into skins."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from aeroscene.scene import Relief
from aeroscene.scene.relief import ground_m
from aeroscene.solids.shapes import Primitive
from flightsim.looks.dressing import ALL_FACES, Piece, dress
from flightsim.looks.paint import Paint
from flightsim.looks.surfaces import Detail, rotation_enu, surface_enu
from flightsim.looks.tessellation import N_BOX_FACES, Surface, box_texture_m, unit_box

_ON_GROUND_M = 0.02  # a face up to this height lies on the ground, where nobody sees it


@dataclass(frozen=True, eq=False)
class WorldMesh:
    """Triangles with paints; the flat faces among them are also kept as polygons."""

    paints: tuple[Paint, ...]
    vertices_enu_m: Float[np.ndarray, "v 3"]
    normals_enu: Float[np.ndarray, "v 3"]
    texture_tiles: Float[np.ndarray, "v 2"]
    """Texture coordinates in tiles of the paint, v up."""
    triangles: Int[np.ndarray, "t 3"]
    """Corners counter-clockwise seen from outside."""
    triangle_paint: Int[np.ndarray, " t"]
    face_first: Int[np.ndarray, " f"]
    """Index of the first vertex of each flat face's ring of corners."""
    face_count: Int[np.ndarray, " f"]
    face_paint: Int[np.ndarray, " f"]

    def corners_enu_m(self) -> Float[np.ndarray, "t 3 3"]:
        """Return the three corners of each triangle."""
        return self.vertices_enu_m[self.triangles]

    def vertex_paint(self) -> Int[np.ndarray, " v"]:
        """Return the paint of each vertex."""
        paint = np.zeros(len(self.vertices_enu_m), dtype=np.int32)
        paint[self.triangles] = self.triangle_paint[:, None]
        return paint

    def is_clear(self) -> Bool[np.ndarray, " t"]:
        """Return true for triangles that sunlight passes through."""
        return np.array([paint.is_clear for paint in self.paints], dtype=bool)[self.triangle_paint]

    def is_lamp(self) -> Bool[np.ndarray, " t"]:
        """Return true for triangles that emit light."""
        return np.array([paint.is_lamp for paint in self.paints], dtype=bool)[self.triangle_paint]


def add_solids(
    builder: MeshBuilder,
    primitives: Sequence[Primitive],
    categories: Mapping[int, str],
    detail: Detail,
) -> None:
    """Dress and tessellate solids.

    Args:
        builder: Receives the surfaces.
        primitives: Solids of the world.
        categories: Categories of the primitives' objects, by id.
        detail: Detail of round shapes.
    """
    pieces = [
        piece
        for primitive in primitives
        for piece in dress(primitive, categories.get(primitive.object_id))
    ]
    # All boxes in a few array operations, because most solids are boxes.
    builder.add_boxes([piece for piece in pieces if piece.primitive.kind == "box"])
    for piece in pieces:
        if piece.primitive.kind != "box":
            is_flat = piece.primitive.kind == "mesh"
            surface = surface_enu(piece.primitive, detail)
            builder.add_surface(surface, piece.paint, is_flat=is_flat)


class MeshBuilder:
    """Collects surfaces into a mesh; faces that lie on the ground are left out."""

    def __init__(self, relief: Relief | None = None) -> None:
        self._relief = relief
        self._paints: dict[Paint, int] = {}
        self._parts: list[tuple[np.ndarray, ...]] = []
        self._n_vertices = 0

    def add_boxes(self, pieces: Sequence[Piece]) -> None:
        """Add the faces of many boxes at once, except those on the ground."""
        if not pieces:
            return
        vertices, axes, normals, _ = unit_box()
        sizes_m = np.array([piece.primitive.size_m for piece in pieces])
        turns = np.array([rotation_enu(piece.primitive) for piece in pieces])
        middles = np.array([piece.primitive.position_enu_m for piece in pieces])
        corners = (vertices * sizes_m[:, None]) @ turns.transpose(0, 2, 1) + middles[:, None]
        directions = normals @ turns.transpose(0, 2, 1)
        tiles = np.array([_tiles_of_box(axes, piece) for piece in pieces])
        shape = (len(pieces), N_BOX_FACES, 4)
        is_shown = np.ones(shape[:2], dtype=bool)
        for row, piece in zip(is_shown, pieces, strict=True):
            if piece.faces != ALL_FACES:
                row[:] = False
                row[list(piece.faces)] = True
        corners = corners.reshape(*shape, 3)
        # A face that looks down is hidden if all of its corners lie on the ground.
        faces_down = directions.reshape(*shape, 3)[:, :, 0, 2] < -0.5
        above_m = corners[..., 2] - ground_m(self._relief, corners[..., 0], corners[..., 1])
        is_shown &= ~faces_down | (above_m > _ON_GROUND_M).any(axis=2)
        paint = np.array([self.paint(piece.paint) for piece in pieces])
        self.add_quads(
            corners[is_shown],
            directions.reshape(*shape, 3)[is_shown],
            tiles.reshape(*shape, 2)[is_shown],
            np.repeat(paint, is_shown.sum(axis=1)),
        )

    def add_quads(
        self, corners: np.ndarray, normals: np.ndarray, tiles: np.ndarray, paint: np.ndarray
    ) -> None:
        """Add flat faces of four corners each.

        Args:
            corners: Corners (n, 4, 3), counter-clockwise from outside, ENU.
            normals: Normal at each corner (n, 4, 3).
            tiles: Texture coordinates at each corner (n, 4, 2).
            paint: Index of each face's paint (n,).
        """
        first = 4 * np.arange(len(corners), dtype=np.int32)
        fan = first[:, None, None] + np.array([(0, 1, 2), (0, 2, 3)], dtype=np.int32)
        self._add(
            corners.reshape(-1, 3),
            normals.reshape(-1, 3),
            tiles.reshape(-1, 2),
            fan.reshape(-1, 3),
            np.repeat(paint, 2),
            first,
            np.full(len(first), 4, dtype=np.int32),
            paint,
        )

    def add_surface(self, surface: Surface, paint: Paint, *, is_flat: bool) -> None:
        """Add a surface.

        Args:
            surface: The surface.
            paint: Its paint.
            is_flat: True if it consists of fans of triangles, one for each flat face.
        """
        number = self.paint(paint)
        first = np.zeros(0, dtype=np.int32)
        if is_flat:
            # Every fan begins with the first corner of its face.
            first = np.unique(surface.triangles[:, 0])
        count = np.diff(np.append(first, len(surface.vertices_m)))
        if not is_flat:
            count = first
        self._add(
            surface.vertices_m,
            surface.normals,
            surface.texture_m / paint.size_m,
            surface.triangles,
            np.full(len(surface.triangles), number),
            first,
            count,
            np.full(len(first), number),
        )

    def paint(self, paint: Paint) -> int:
        """Return the index of a paint in the mesh; a new paint gets the next one."""
        return self._paints.setdefault(paint, len(self._paints))

    def mesh(self) -> WorldMesh:
        """Return the mesh of all collected surfaces."""
        empty = tuple(np.zeros(shape) for shape in ((0, 3), (0, 3), (0, 2)))
        whole = np.zeros((0, 3), np.int32), *(np.zeros(0, np.int32) for _ in range(4))
        columns = zip((*empty, *whole), *self._parts, strict=True)
        joined = [np.concatenate(column) for column in columns]
        integers = [array.astype(np.int32) for array in joined[3:]]
        return WorldMesh(tuple(self._paints), *joined[:3], *integers)

    def _add(self, vertices: np.ndarray, *others: np.ndarray) -> None:
        normals, tiles, triangles, triangle_paint, first, count, face_paint = others
        n = self._n_vertices
        self._parts.append(
            (vertices, normals, tiles, triangles + n, triangle_paint, first + n, count, face_paint)
        )
        self._n_vertices += len(vertices)


def _tiles_of_box(axes: np.ndarray, piece: Piece) -> np.ndarray:
    """Texture coordinates of a box's corners, in tiles."""
    if piece.paint.is_fitted:
        return axes[:, :2].astype(float)
    return box_texture_m(axes, np.array(piece.primitive.size_m)) / piece.paint.size_m
