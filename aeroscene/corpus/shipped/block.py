"""Some scenes as bytes and back: what an archive compresses in one piece."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import get_args

import numpy as np
from jaxtyping import Float64

from aeroscene.corpus.shipped.areas import (
    AreaColumns,
    build_areas,
    gather_areas,
    read_areas,
    write_areas,
)
from aeroscene.corpus.shipped.columns import ColumnReader, ColumnWriter
from aeroscene.corpus.shipped.decimals import join_doubles, split_doubles
from aeroscene.corpus.shipped.objects import (
    LENGTH_DIGITS,
    Column,
    ObjectColumns,
    build_objects,
    gather_objects,
    read_objects,
    write_objects,
)
from aeroscene.scene import Scene, SceneDomain, Vector3

_DOMAINS: tuple[SceneDomain, ...] = get_args(SceneDomain)
_FRAME_DIGITS = (*[LENGTH_DIGITS] * 9, 6, 7, 7, LENGTH_DIGITS)
"""Decimals of what `_frame` lists."""
_CEILING = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """Scenes, not built yet."""

    scene_ids: list[str]
    domains: Column
    seeds: Column
    frames: Float64[np.ndarray, "scenes 13"]
    objects: ObjectColumns
    areas: AreaColumns
    themes: list[str]

    def scene(self, number: int) -> Scene:
        """One of the scenes, by its place in the block.

        Raises:
            SceneError: If it breaks a rule of the schema.
        """
        scene_id = self.scene_ids[number]
        frame = self.frames[number].tolist()
        return Scene(
            scene_id=scene_id,
            domain=_DOMAINS[int(self.domains[number])],
            seed=int(self.seeds[number]),
            extent_min_enu_m=_vector(frame[0:3]),
            extent_max_enu_m=_vector(frame[3:6]),
            start_position_enu_m=_vector(frame[6:9]),
            start_yaw_rad=frame[9],
            latitude_deg=frame[10],
            longitude_deg=frame[11],
            altitude_m=frame[12],
            objects=build_objects(self.objects, number, scene_id),
            interaction_areas=build_areas(self.areas, self.objects, number),
            theme=self.themes[number],
        )


def _frame(scene: Scene) -> tuple[float, ...]:
    return (
        *scene.extent_min_enu_m,
        *scene.extent_max_enu_m,
        *scene.start_position_enu_m,
        scene.start_yaw_rad,
        scene.latitude_deg,
        scene.longitude_deg,
        scene.altitude_m,
    )


def _vector(values: list[float]) -> Vector3:
    x, y, z = values
    return x, y, z


def encode_block(scenes: Sequence[Scene]) -> bytes:
    """Scenes as compressed bytes; the same bytes for equal scenes."""
    writer = ColumnWriter()
    writer.add_plain([scene.scene_id for scene in scenes])
    writer.add(np.array([_DOMAINS.index(scene.domain) for scene in scenes], np.int64))
    writer.add(np.array([scene.seed for scene in scenes], np.int64))
    frames = np.array([_frame(scene) for scene in scenes], np.float64)
    for column, digits in zip(frames.T, _FRAME_DIGITS, strict=True):
        writer.add_decimals(split_doubles(column, digits))
    objects = gather_objects(scenes)
    write_objects(objects, writer)
    write_areas(gather_areas(scenes), objects, _ceilings(frames), writer)
    themes = [scene.theme for scene in scenes]
    if any(themes):
        writer.add_plain(themes)
    return writer.to_bytes()


def decode_block(data: bytes) -> Block:
    """The scenes in bytes that `encode_block` made; whether they are those is for the caller."""
    reader = ColumnReader(data)
    scene_ids = reader.take_plain(list[str])
    domains, seeds = reader.take(), reader.take()
    columns = [join_doubles(reader.take_decimals(), digits) for digits in _FRAME_DIGITS]
    frames = np.stack(columns, axis=1)
    objects = read_objects(reader)
    return Block(
        scene_ids=scene_ids,
        domains=domains,
        seeds=seeds,
        frames=frames,
        objects=objects,
        areas=read_areas(reader, objects, _ceilings(frames)),
        themes=[""] * len(scene_ids) if reader.is_at_end else reader.take_plain(list[str]),
    )


def _ceilings(frames: Float64[np.ndarray, "scenes 13"]) -> Column:
    return split_doubles(frames[:, _CEILING], LENGTH_DIGITS).units
