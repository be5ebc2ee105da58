"""Contact sheets: a picture of each scene, with a caption from the manifest."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from PIL import Image

from aeroscene.corpus.summary import Entry, SceneSet, SceneSummary
from aeroscene.files import replacing
from aeroscene.processes import run_all
from aeroscene.scene import Scene
from flightsim.cameras import open_camera_renderer
from flightsim.cameras.framing import frame_points
from flightsim.looks.cutting import cut_at
from flightsim.world import build_world
from scenarios.pictures.lettering import INK_RGB, PALE_RGB, PAPER_RGB, Picture, write

ASPECT = 4 / 3
_FOV_RAD = math.radians(40.0)
_AZIMUTH_RAD = math.radians(-118.0)
_ELEVATION_RAD = math.radians(36.0)
_INDOOR_ELEVATION_RAD = math.radians(58.0)
_OVER = 2
"""Supersampling factor, which smooths edges for less than a fine picture costs."""
_CUT_M = 2.6
"""Height above the floor at which indoor scenes are cut: ceilings, roofs and upper storeys are
removed."""

_GAP_PX = 10
_CAPTION_PX = 46


def draw_sheet(
    dataset: SceneSet[Entry],
    out: Path,
    columns: int,
    width: int,
    jobs: int,
    on_scene: Callable[[], None],
) -> None:
    """Draw every scene of a dataset into one PNG file.

    Args:
        dataset: Scenes to draw.
        out: File to write, whole or not at all.
        columns: Number of pictures side by side.
        width: Width of one picture, pixels.
        jobs: Number of processes.
        on_scene: Called after each picture.

    Raises:
        SceneError: If a scene cannot be read.
        OSError: If the file cannot be written.
    """
    cells: list[Picture] = []
    # Processes get a set without entries, because those of a whole dataset are large to send.
    draw = partial(_draw_cell, dataset.select(()), width)
    with closing(run_all(draw, dataset.entries, jobs)) as results:
        for cell in results:
            cells.append(cell)
            on_scene()
    with replacing(out) as file:
        Image.fromarray(tile(cells, columns)).save(file, format="png")


def _draw_cell(reader: SceneSet[Entry], width: int, entry: Entry) -> Picture:
    scene = reader.read(entry)
    return np.vstack([draw_scene(scene, width), _caption(entry, width)])


def draw_scene(scene: Scene, width: int, aspect: float = ASPECT) -> Picture:
    """Draw a scene from above one corner; indoor scenes are cut open above the furniture.

    Args:
        scene: Scene to draw.
        width: Width of the picture, pixels.
        aspect: Width over height.
    """
    height = round(width / aspect)
    world = build_world(scene)
    is_indoor = scene.domain == "indoor"
    if is_indoor:
        cut_m = scene.extent_min_enu_m[2] + _CUT_M
        world = replace(world, solids=cut_at(world.solids, cut_m))
    eye, target = frame_points(
        _outline(scene, _CUT_M if is_indoor else math.inf),
        azimuth_rad=_AZIMUTH_RAD,
        # Steeper indoors, because walls would hide the floor.
        elevation_rad=_INDOOR_ELEVATION_RAD if is_indoor else _ELEVATION_RAD,
        vertical_fov_rad=_FOV_RAD,
        aspect=aspect,
    )
    with closing(open_camera_renderer(world, _OVER * width, _OVER * height)) as renderer:
        large = renderer.render_view(world.new_data(), eye, target, _FOV_RAD).rgb
    return np.array(Image.fromarray(large).reduce(_OVER))


def _outline(scene: Scene, height_m: float) -> np.ndarray:
    """Return the corners of all boxes, capped at a height above the scene's floor."""
    corners = np.concatenate([obj.bbox.corners() for obj in scene.objects])
    top = scene.extent_min_enu_m[2] + height_m
    return np.minimum(corners, [np.inf, np.inf, top])


def _caption(entry: SceneSummary, width: int) -> Picture:
    strip = np.full((_CAPTION_PX, width, 3), PAPER_RGB, dtype=np.uint8)
    areas = f"{entry.n_small} small, {entry.n_medium} medium, {entry.n_large} large areas"
    write(strip, f"{entry.index:04d} {entry.domain}", (2, 3), 15, INK_RGB)
    write(strip, f"{entry.n_coarse} + {entry.n_fine} objects, {areas}", (2, 24), 12, PALE_RGB)
    return strip


def tile(cells: Sequence[Picture], columns: int) -> Picture:
    """Arrange pictures row by row, with gaps between them.

    Args:
        cells: Pictures of equal size, at least one.
        columns: Pictures side by side, at most.
    """
    height, width, _ = cells[0].shape
    columns = min(columns, len(cells))
    rows = -(-len(cells) // columns)  # rounded up
    size = (rows * (height + _GAP_PX) + _GAP_PX, columns * (width + _GAP_PX) + _GAP_PX, 3)
    sheet = np.full(size, PAPER_RGB, dtype=np.uint8)
    for number, cell in enumerate(cells):
        row, column = divmod(number, columns)
        top, left = _GAP_PX + row * (height + _GAP_PX), _GAP_PX + column * (width + _GAP_PX)
        sheet[top : top + height, left : left + width] = cell
    return sheet
