"""Draw docs/gallery.md and its pictures, all of them or some.

python tools/draw_gallery.py
python tools/draw_gallery.py --only categories --out chart
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import tyro
from draw_scene import DrawCfg, picture, save
from drawing.category_chart import category_chart
from drawing.gallery_page import Shown, write_page
from drawing.gallery_scenes import PLACES, Place
from drawing.views import choose_view
from matplotlib import colormaps

from aeroscene.sources import load_scene
from autonomy.types import quat_about_up
from flightsim.cameras import RgbdFrame, open_camera_renderer
from flightsim.cameras.view import Quality
from flightsim.vehicles.catalogue import airframe_by_name
from flightsim.world import build_world
from scenarios.cli.terminal import terminal
from scenarios.pictures.lettering import label

# A picture of a place fills the page's width; an on-board one has the size of the camera, and a
# tile is half a place wide.
_PLACE_PX = (832, 468)
_ONBOARD_PX = (320, 240)
_TILE_PX = (416, 300)
_GENERATED = (36, 48)
"""Numbers of the scenes that show what the model makes; 42 is among them."""
_COLUMNS = 3  # tiles in a row
_CUT_M = 2.6  # indoors, below the ceiling, so that one sees in
_MOST_BYTES = 3_200_000  # the pictures are in the repository
_FAR_M = 40.0  # end of the colour scale of depth
_ONBOARD = {
    "urban": "Shop fronts and a blue car; below, a landing mark on the pavement.",
    "waterfront": "Boats at the quay, beside a brick house; below, a landing mark on the lawn.",
    "office": "Glass panes along a corridor; below, a landing pad on tiles.",
}
"""Places to show on board, and what is seen there."""

Section = Literal["generated", "places", "onboard", "areas", "categories"]


@dataclass(frozen=True, kw_only=True)
class GalleryCfg:
    """Draw the gallery."""

    out: Path = Path("docs/images/gallery")
    """Folder for the pictures."""
    page: Path = Path("docs/gallery.md")
    """The page that shows them; written when all sections are drawn."""
    only: tuple[Section, ...] = ()
    """Sections to draw; all of them when none is named."""
    quality: Quality = "fine"
    """"fast" draws a draft."""


def draw(cfg: GalleryCfg) -> None:
    """Draw and write the pictures, and the page if all sections are drawn.

    Raises:
        SystemExit: If the pictures together have more bytes than the repository is to bear.
    """
    console = terminal(stderr=True)
    sections = cfg.only or ("generated", "places", "onboard", "areas", "categories")
    shown: list[Shown] = []
    makers: dict[Section, Callable[[GalleryCfg], list[Shown]]] = {
        "generated": _generated,
        "places": _places,
        "onboard": _onboard,
        "areas": _areas,
        "categories": _categories,
    }
    for section in sections:
        console.print(f"drawing {section}")
        shown += makers[section](cfg)
    files = [file for item in shown for file in (item.file, item.beside) if file is not None]
    n_bytes = sum((cfg.out / file).stat().st_size for file in files)
    console.print(f"{len(files)} pictures, {n_bytes / 1e6:.2f} MB")
    if n_bytes > _MOST_BYTES:
        raise SystemExit(f"the pictures are {n_bytes} bytes; valid: at most {_MOST_BYTES}")
    # The page shows every section, so that a part of them does not rewrite it.
    if not cfg.only:
        write_page(cfg.page, cfg.out, shown)


def _generated(cfg: GalleryCfg) -> list[Shown]:
    """Shipped scenes side by side, roofs taken off indoors."""
    rows = []
    for start in range(*_GENERATED, _COLUMNS):
        tiles = [_tile(cfg, number) for number in range(start, start + _COLUMNS)]
        rows.append(np.hstack(tiles))
    file = "generated.jpg"
    save(np.vstack(rows), cfg.out / file)
    last = _GENERATED[1] - 1
    text = f"Scenes {_GENERATED[0]} to {last}, in turn mixed, outdoor and indoor."
    return [Shown("generated", file, "Twelve of 1,016", text, None)]


def _tile(cfg: GalleryCfg, number: int) -> np.ndarray:
    is_indoor = load_scene(str(number)).domain == "indoor"
    _, rgb = picture(
        DrawCfg(
            out=cfg.out,
            scene=str(number),
            cut_height_m=_CUT_M if is_indoor else None,
            size_px=_TILE_PX,
            quality=cfg.quality,
        )
    )
    return label(rgb, str(number), size_px=16)


def _places(cfg: GalleryCfg) -> list[Shown]:
    shown = []
    for place in PLACES:
        beside = None
        if place.generated is not None:
            beside = f"{place.name}-generated.jpg"
            _draw_place(cfg, place, place.generated, beside)
        file = f"{place.name}.jpg"
        _draw_place(cfg, place, place.scene, file)
        shown.append(
            Shown("places", file, place.title, place.text, place.scene, beside, place.generated)
        )
    return shown


def _draw_place(cfg: GalleryCfg, place: Place, scene: str, file: str) -> None:
    draw_cfg = DrawCfg(
        out=cfg.out / file,
        scene=scene,
        view=place.view,
        cut_height_m=place.cut_height_m,
        size_px=_PLACE_PX,
        quality=cfg.quality,
    )
    save(picture(draw_cfg)[1], draw_cfg.out)


def _scene_of(name: str) -> str:
    return next(place.scene for place in PLACES if place.name == name)


def _onboard(cfg: GalleryCfg) -> list[Shown]:
    """Frames of the cameras of an Iris: colour and depth, forward and down, at 320 x 240."""
    shown = []
    for name, text in _ONBOARD.items():
        file = f"onboard-{name}.jpg"
        save(_onboard_strip(_scene_of(name)), cfg.out / file)
        shown.append(Shown("onboard", file, f"On board, {name}", text, _scene_of(name)))
    return shown


def _onboard_strip(number: str) -> np.ndarray:
    scene = load_scene(number)
    world = build_world(scene, airframe_by_name("iris"))
    renderer = open_camera_renderer(world, *_ONBOARD_PX)
    # The vehicle is put where a view of its forward camera shows most; no flight is needed.
    view = choose_view(world, "forward", _ONBOARD_PX[0] / _ONBOARD_PX[1], renderer)
    x, y, _ = np.subtract(view.target_enu_m, view.eye_enu_m).tolist()
    yaw = math.atan2(y, x)
    data = world.new_data()
    data.qpos[:3] = view.eye_enu_m
    data.qpos[3:7] = quat_about_up(yaw)
    tiles = []
    for camera in ("forward", "down"):
        frame = renderer.render(data, camera, 0)
        tiles += [label(frame.rgb, camera, size_px=13), _depth_rgb(frame)]
    renderer.close()
    return np.hstack(tiles)


def _depth_rgb(frame: RgbdFrame) -> np.ndarray:
    """Depth in colours, the nearest red and the farthest blue; black where there is nothing."""
    # The farthest 3% do not set the scale: a gap between houses would make all else one colour.
    far_m = min(_FAR_M, float(np.quantile(frame.depth_m[np.isfinite(frame.depth_m)], 0.97)))
    low, high = math.log(float(frame.depth_m.min())), math.log(far_m)
    # By the logarithm, because most of a picture is near.
    near = np.clip((high - np.log(frame.depth_m)) / max(0.05, high - low), 0.0, 1.0)
    rgb = (255 * colormaps["turbo"](near)[..., :3]).astype(np.uint8)
    rgb[~np.isfinite(frame.depth_m)] = 0
    return rgb


def _areas(cfg: GalleryCfg) -> list[Shown]:
    shown = []
    for name, cut_height_m in (("urban", None), ("store", 2.5)):
        file = f"areas-{name}.jpg"
        _, rgb = picture(
            DrawCfg(
                out=cfg.out / file,
                scene=_scene_of(name),
                view="overview",
                cut_height_m=cut_height_m,
                areas=True,
                size_px=_PLACE_PX,
                quality=cfg.quality,
            )
        )
        save(rgb, cfg.out / file)
        shown.append(Shown("areas", file, f"Areas, {name}", "", _scene_of(name)))
    return shown


def _categories(cfg: GalleryCfg) -> list[Shown]:
    save(category_chart(cfg.quality), cfg.out / "categories.jpg")
    return [Shown("categories", "categories.jpg", "All 70 categories", "", None)]


if __name__ == "__main__":
    draw(tyro.cli(GalleryCfg))
