"""One picture of every category: three variants each, small, middling and large."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from rich.progress import track

from aeroscene.scene import OrientedBox, Scene, SceneObject
from aeroscene.scene.catalogue import CATALOGUE, Category
from aeroscene.solids.shapes import Primitive, object_primitives
from flightsim.cameras import open_camera_renderer
from flightsim.cameras.framing import frame_points
from flightsim.cameras.view import Quality
from flightsim.world import build_world
from scenarios.pictures.lettering import label

_CELL_PX = (236, 178)
_COLUMNS = 7
_FOV_DEG = 24.0
_SHARES = (0.2, 0.5, 0.8)
"""Positions of the variants in the range of sizes."""
_MOST_M = 18.0
"""A road of 120 m would be a line in its picture."""


def category_chart(quality: Quality) -> np.ndarray:
    """Draw all categories, each in a cell with its name, in the order of the catalogue.

    Args:
        quality: Quality of the cells' pictures.

    Returns:
        rgb (h, w, 3) uint8.
    """
    cells = [
        label(_cell(category, quality), f"{category.name}", size_px=15)
        for category in track(list(CATALOGUE.values()), description="categories")
    ]
    width, height = _CELL_PX
    # White cells fill the last row.
    cells += [np.full((height, width, 3), 255, np.uint8)] * (-len(cells) % _COLUMNS)
    rows = [np.hstack(cells[i : i + _COLUMNS]) for i in range(0, len(cells), _COLUMNS)]
    return np.vstack(rows)


def _cell(category: Category, quality: Quality) -> np.ndarray:
    primitives, corners_enu_m = [], []
    for obj in _variants(category):
        primitives += object_primitives(obj)
        corners_enu_m.append(obj.bbox.corners())
    # Objects come as solids beside an empty scene, because a valid scene would need room for each.
    world = build_world(_stage(), extra=(*_floor(), *primitives))
    width, height = _CELL_PX
    eye, target = frame_points(
        np.concatenate(corners_enu_m),
        azimuth_rad=math.radians(-148.0),
        elevation_rad=math.radians(24.0),
        vertical_fov_rad=math.radians(_FOV_DEG),
        aspect=width / height,
        margin=1.12,
    )
    renderer = open_camera_renderer(world, width, height)
    frame = renderer.render_view(world.new_data(), eye, target, math.radians(_FOV_DEG), quality)
    renderer.close()
    return frame.rgb


def _variants(category: Category) -> Iterator[SceneObject]:
    """Three objects side by side, the smallest on the left, their fronts to the sun."""
    ranges = (category.length_m, category.width_m, category.height_m)
    sizes = [
        # Categories that are longer than `_MOST_M` at their smallest keep the smallest size.
        tuple(min(low + share * (high - low), max(low, _MOST_M)) for low, high in ranges)
        for share in _SHARES
    ]
    # The largest sets the gap, so that a row of low walls stays apart as far as one of towers.
    gap_m = 0.25 * max(max(size[:2]) for size in sizes)
    y = 0.0
    for index, (length, width, height) in enumerate(sizes):
        y -= width / 2
        yield SceneObject(
            id=index,
            scene_id="chart",
            parent_id=None,
            category_id=category.id,
            bbox=OrientedBox((0.0, y, height / 2), (0.0, 0.0, 0.0, 1.0), (length, width, height)),
            domain="outdoor",
            attributes={},
        )
        y -= width / 2 + gap_m


def _floor() -> tuple[Primitive, ...]:
    return (
        Primitive(
            kind="box",
            position_enu_m=(0.0, 0.0, -0.05),
            quat_wxyz=(1.0, 0.0, 0.0, 0.0),
            # A millimetre thicker than twice its depth, so that it lies above the ground and hides
            # it.
            size_m=(400.0, 400.0, 0.101),
            material="plaster_white",
            object_id=0,
            collides=False,
        ),
    )


def _stage() -> Scene:
    return Scene(
        scene_id="chart",
        domain="outdoor",
        seed=0,
        extent_min_enu_m=(-40.0, -40.0, 0.0),
        extent_max_enu_m=(40.0, 40.0, 40.0),
        start_position_enu_m=(0.0, 0.0, 0.0),
        start_yaw_rad=0.0,
        latitude_deg=47.4,
        longitude_deg=8.5,
        altitude_m=488.0,
        objects=(),
    )
